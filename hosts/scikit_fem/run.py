# SPDX-License-Identifier: MIT OR Apache-2.0
"""Moves the cube of host.py through one and a quarter cycles, per contact method: loop CSV, picture, result row."""

import argparse
import json
import os
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # small dense matrices: more threads only wait for each other

import numpy as np

from host import KN, LOAD, assemble, follow
from mepc import Law

OUTPUT = Path(__file__).resolve().parents[2] / "build/hosts/scikit_fem"
AMPLITUDE = 0.02
MU, GCR, CHI = 0.43, 0.002, 2.5
PRESSURE = LOAD / 100  # the mean one, on 10 x 10 mm
STATUS = ("open", "stick", "micro_slip", "gross_slip")
METHODS = ("memory", "penalty")


def properties(method, gcr=GCR, chi=CHI, reference_pressure=PRESSURE):
    """The keywords of the law; the critical slip is gcr at the mean pressure."""
    return {"mu": MU, "gcr": gcr, "exponent": chi, "method": method, "reference_pressure": reference_pressure, "kn": KN}


def history(steps):
    """Platen positions: load, to +A in `steps`, to -A and back in 2 `steps` each; fine after each reversal."""
    def graded(count):
        return (np.arange(1, count + 1) / count) ** 1.5

    swing = 2 * AMPLITUDE * graded(2 * steps)
    return np.concatenate([[0], AMPLITUDE * graded(steps), AMPLITUDE - swing, swing - AMPLITUDE])


def loop(bodies, done):
    """The columns of the CSV file. reaction_1 is summed over the fixed nodes: it must balance force_1."""
    displacement = np.array([step.displacement for step in done])
    status = np.array([step.state[:, 0] for step in done])
    return {
        "displacement_1": displacement[:, -3],
        "force_1": displacement @ bodies.stiffness[-3],
        "reaction_1": displacement @ bodies.support[0],
        "dissipated_energy": np.cumsum([step.dissipated for step in done]),
        **{name: (status == number).sum(axis=1) for number, name in enumerate(STATUS)},
        "iterations": np.array([sum(len(norms) - 1 for norms in step.residuals) for step in done]),
    }


def plateau(table, steps):
    """The least |force| at the three turning points, over mu N."""
    return np.abs(table["force_1"][[steps, 3 * steps, 5 * steps]]).min() / (MU * LOAD)


def cycle(table, steps):
    """Area of the closed cycle +A, -A, +A by the trapezoidal rule, and the library's dissipation in it."""
    area = np.trapezoid(table["force_1"][steps:], table["displacement_1"][steps:])
    return area, table["dissipated_energy"][-1] - table["dissipated_energy"][steps]


def picture(tables, path):
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6.4, 4.4), layout="constrained")
    for method, table in tables.items():
        axes.plot(1e3 * table["displacement_1"], table["force_1"], ".-", markersize=3, linewidth=1, label=method)
    for sign in (-1, 1):
        axes.axhline(sign * MU * LOAD, color="grey", linestyle=":", linewidth=1, label="mu N" if sign > 0 else None)
    axes.set(xlabel="platen displacement (um)", ylabel="force (N)", title="Cube on a flat, one and a quarter cycles")
    axes.legend(loc=(0.56, 0.25))
    figure.savefig(path, dpi=120)


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--small", action="store_true", help="5 mm elements (9 contact points) instead of 2 mm (36)")
    options.add_argument("--method", choices=[*METHODS, "all"], default="all")
    options.add_argument("--output", type=Path, default=OUTPUT, help="directory, default build/hosts/scikit_fem")
    options = options.parse_args()
    size, steps = 5 if options.small else 2, 24
    options.output.mkdir(parents=True, exist_ok=True)

    bodies = assemble(size)
    tables, rows = {}, []
    for method in METHODS if options.method == "all" else [options.method]:
        began = time.perf_counter()
        done = follow(bodies, Law(**properties(method)), history(steps), show=f"scikit-fem {method}")
        tables[method] = table = loop(bodies, done)
        area, dissipated = cycle(table, steps)
        rows.append({
            "host": "scikit-fem", "element": f"hex8 {size} mm, {method}",
            "steps": len(done), "iterations": int(table["iterations"].sum()),
            "plateau_over_muN": plateau(table, steps), "loop_area": area,
            "difference": max(abs(plateau(table, steps) - 1), abs(area / dissipated - 1)),
            "seconds": time.perf_counter() - began,
        })
        np.savetxt(options.output / f"{method}.csv", np.transpose(list(table.values())), fmt="%.17g",
                   delimiter=",", header=",".join(table), comments="")
    picture(tables, options.output / "loops.png")
    (options.output / "row.json").write_text(json.dumps(rows, indent=1) + "\n")
    for row in rows:
        print(", ".join(f"{key} {value:.7g}" if isinstance(value, float) else f"{key} {value}"
                        for key, value in row.items()))


if __name__ == "__main__":
    main()
