# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the studies do alike: histories of motion, the tool that identifies a loop, files and where they come from."""

import json
import platform
import subprocess
from importlib.metadata import version
from pathlib import Path

import numpy as np

from common import read_csv, write_csv  # noqa: F401

ROOT = Path(__file__).resolve().parents[1]
TOOL = ROOT / "target/release/mepc"


def cycle(amplitude, quarter=16):
    """First loading to +A in `quarter` steps, to -A and back in twice as many each; fine after each reversal."""
    def branch(start, end, steps):
        return start + (end - start) * (np.arange(1, steps + 1) / steps) ** 1.5

    a = amplitude
    return np.concatenate([branch(0, a, quarter), branch(a, -a, 2 * quarter), branch(-a, a, 2 * quarter)])


# Of F_s. The residual line of a joint is slightly bent; a stricter tolerance takes the bend for micro-slip.
TOLERANCE = 0.02


def identify(file):
    """What `mepc identify --json` makes of a loop: least squares, and the paper's procedure under "paper".

    The tool's exit code 3 says that the loop shows no gross slip; its words are then in "warnings"."""
    run = subprocess.run([TOOL, "identify", file, "--json", "--tolerance", str(TOLERANCE)], capture_output=True, text=True)
    if run.returncode not in (0, 3):
        raise RuntimeError(f"mepc identify {file}: {run.stderr}")
    return json.loads(run.stdout)


def provenance(**more):
    """What a result was made with."""
    packages = ("numpy", "scipy", "scikit-fem", "pypardiso", "mkl")
    text = (ROOT / "Cargo.toml").read_text()
    mepc = next(line.split('"')[1] for line in text.splitlines() if line.startswith("version"))
    return {
        "mepc": mepc,
        "python": platform.python_version(),
        **{package: version(package) for package in packages},
        **more,
    }
