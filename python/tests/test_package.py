# SPDX-License-Identifier: MIT OR Apache-2.0
"""What comes with the package: paths, program, version, and the gallery."""

import os
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import mepc

GALLERY = Path(__file__).resolve().parents[1] / "gallery.py"


def module(*arguments, **environment):
    return subprocess.run([sys.executable, "-m", "mepc", *arguments], capture_output=True, text=True,
                          env=os.environ | environment)


def test_paths():
    assert isinstance(mepc.library, str) and Path(mepc.library).is_file()
    for name in ("mepc.h", "mepc.f90"):
        assert (Path(mepc.include) / name).is_file()
    assert module("--library").stdout.strip() == mepc.library
    assert module("--include").stdout.strip() == mepc.include
    assert module().returncode == 2


def test_the_program_is_of_the_same_version():
    tool = module("--tool").stdout.strip()
    said = subprocess.run([tool, "--version"], capture_output=True, text=True, check=True).stdout
    assert said.strip() == f"mepc {mepc.__version__}" == module("--version").stdout.strip()


def test_another_library_may_be_named():
    assert module("--library", MEPC_LIBRARY=mepc.library).stdout.strip() == mepc.library
    wrong = module("--library", MEPC_LIBRARY="/nowhere/libmepc.so")
    assert wrong.returncode == 1 and "/nowhere/libmepc.so: no such file" in wrong.stderr


def test_gallery():
    gallery = runpy.run_path(str(GALLERY))
    limit = gallery["LIMIT"]
    _, traction = gallery["loop"]()
    assert traction.max() == pytest.approx(limit, rel=1e-12) and traction.min() == pytest.approx(-limit, rel=1e-12)
    slip, traction, dissipated = gallery["circle"]()
    radius = np.hypot(*traction[-100:].T)
    assert radius.max() / radius.min() < 1.01 and radius.max() < limit
    # Work of a turn of a closed path is dissipated.
    work = (traction[-201:-1] + traction[-200:]) / 2 * np.diff(slip[-201:], axis=0)
    assert dissipated == pytest.approx(work.sum(), rel=0.02)
    slip, loops = gallery["ripple"]()
    for traction, dissipated in loops.values():
        # A closed cycle: its area is what is dissipated, or created.
        work = (traction[-201:-1] + traction[-200:]) / 2 @ np.diff(slip[-201:])
        assert dissipated == pytest.approx(work / (limit * gallery["GCR"]), abs=1e-3)
    assert loops["consistent"][1] > 0 > loops["proportional"][1]
    amplitude, dissipated, exact = gallery["damping"]()
    np.testing.assert_allclose(dissipated, exact, rtol=1e-9)
