"""What the run.py of every host does the same way: options, progress, CSV files, pictures."""

import argparse
from pathlib import Path

import matplotlib
import mepc

matplotlib.use("Agg")
import matplotlib.pyplot as pyplot  # noqa: E402
import numpy as np  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]


def options(host, description):
    """--small, --library, --output; the output directory exists afterwards."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--small", action="store_true", help="coarser meshes and fewer steps")
    parser.add_argument("--library", type=Path, default=Path(mepc.library),
                        help="default: $MEPC_LIBRARY, or the one of the package mepc")
    parser.add_argument("--output", type=Path, default=ROOT / "build/hosts" / host, help="default: build/hosts/HOST")
    given = parser.parse_args()
    given.library = given.library.resolve()
    if not given.library.is_file():
        parser.error(f"no library {given.library}: run make library first")
    given.output.mkdir(parents=True, exist_ok=True)
    return given


def write_csv(file, columns, comment):
    """One column per entry."""
    np.savetxt(
        file, np.column_stack(list(columns.values())), fmt="%.17g", delimiter=",",
        header=f"# {comment}\n" + ",".join(columns), comments="",
    )


def read_csv(file):
    """Columns by name; None if there is no such file."""
    if not file.exists():
        return None
    lines = [line for line in file.read_text().splitlines() if not line.startswith("#")]
    return dict(zip(lines[0].split(","), np.loadtxt(lines[1:], delimiter=",", ndmin=2).T))


def picture(file, title, curves):
    """Loops of force over mu N. `curves`: label, displacement, force, style."""
    figure, axes = pyplot.subplots(figsize=(6.4, 5.6), layout="constrained")
    for label, displacement, force, style in curves:
        axes.plot(1e3 * np.asarray(displacement), force, style, label=label, markersize=4, markerfacecolor="none")
    for sign in (-1, 1):
        axes.axhline(sign, color="grey", linestyle=":", linewidth=1)
    axes.set(xlabel="displacement of the top face (µm)", ylabel="tangential force / (mu N)", title=title)
    figure.legend(loc="outside lower center", fontsize="small")
    figure.savefig(file, dpi=110)
    pyplot.close(figure)
