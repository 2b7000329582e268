# SPDX-License-Identifier: MIT OR Apache-2.0
"""Where the time of an iteration goes, on one rank and on more: strong and weak scaling of flat and slider.

    python hosts/dolfinx/scaling.py [--ranks 1,2] [--repeat 3]

The first steps of the history; each figure is the smallest of the repetitions. Strong: the same mesh on all numbers of
ranks; weak: a mesh of as many cells more. Table to build/hosts/dolfinx/scaling.csv."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse  # noqa: E402
import csv  # noqa: E402
import json  # noqa: E402
import subprocess  # noqa: E402
import sys  # noqa: E402
from pathlib import Path  # noqa: E402

HERE = Path(__file__).resolve().parent
OUTPUT = HERE.parents[1] / "build/hosts/dolfinx/scaling.csv"
QUARTER, STEPS = 4, 4
# Seconds per iteration of Newton's method, from the events of PETSc and of host.py. set-up: factorisation or multigrid; law and
# scatter are parts of residual and jacobian.
PARTS = {"set-up": "PCSetUp", "solve": "KSPSolve", "law": "mepc law", "scatter": "mepc scatter", "residual": "mepc residual",
         "jacobian": "mepc jacobian", "all": "SNESSolve"}


def measure(along, linear):
    """Under mpirun: prints one line of JSON."""
    from mpi4py import MPI
    from petsc4py import PETSc

    PETSc.Log.begin()
    import numpy as np

    from host import Solver
    from models import flat_slider, shared
    from structure import Structure

    comm = MPI.COMM_WORLD
    model = shared(comm, lambda: flat_slider(along, QUARTER))
    structure = Structure(comm, model)
    solver = Solver(structure, model, linear, say=lambda text: None)
    now, iterations, inner = solver.start(), 0, 0
    for displacement in model.history[:STEPS]:
        now = solver.advance(now, np.array([displacement, 0.0]))
        iterations, inner = iterations + now.iterations, inner + now.linear
    seconds = {part: PETSc.Log.Event(event).getPerfInfo()["time"] / iterations for part, event in PARTS.items()}
    longest = {part: comm.allreduce(value, MPI.MAX) for part, value in seconds.items()}
    pairs = comm.gather(len(structure.own_pairs))
    if comm.rank == 0:
        print(json.dumps({
            "ranks": comm.size, "linear": linear, "along": along, "unknowns": 3 * structure.nodes,
            "pairs": structure.pairs, "straddling": structure.straddling, "most_pairs_on_a_rank": max(pairs),
            "iterations": iterations, "linear_per_iteration": round(inner / iterations, 1),
            **{f"{part}_s": longest[part] for part in PARTS}, "law_share": longest["law"] / longest["all"]}))


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--ranks", default="1,2", help="numbers of ranks, default 1,2")
    options.add_argument("--repeat", type=int, default=3)
    options.add_argument("--direct", default="5,6", help="elements per edge of the cube for each number of ranks, MUMPS")
    options.add_argument("--multigrid", default="8,10", help="the same for the iterative solver")
    given = options.parse_args()
    ranks = [int(text) for text in given.ranks.split(",")]
    rows = []
    for linear in ("direct", "multigrid"):
        meshes = [int(text) for text in getattr(given, linear).split(",")]
        if len(meshes) != len(ranks):
            options.error(f"--{linear} {getattr(given, linear)}: as many meshes as numbers of ranks were expected")
        for number, along in [*((number, meshes[0]) for number in ranks), *zip(ranks[1:], meshes[1:])]:
            command = [Path(sys.executable).parent / "mpirun", "-n", number, sys.executable, __file__, "--measure", along,
                       linear]
            done = [json.loads(subprocess.run([str(part) for part in command], check=True, capture_output=True,
                                              text=True).stdout) for _ in range(given.repeat)]
            row = min(done, key=lambda one: one["all_s"])
            rows.append(row)
            print(", ".join(f"{key} {value:.3g}" if isinstance(value, float) else f"{key} {value}"
                            for key, value in row.items()), flush=True)
    OUTPUT.parent.mkdir(parents=True, exist_ok=True)
    with open(OUTPUT, "w", newline="") as out:
        writer = csv.DictWriter(out, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--measure"]:
        measure(int(sys.argv[2]), sys.argv[3])
    else:
        main()
