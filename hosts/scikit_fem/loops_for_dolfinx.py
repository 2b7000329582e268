# SPDX-License-Identifier: MIT OR Apache-2.0
"""The loops that hosts/dolfinx is compared with: the host here, and studies/lap_joint with plain hexahedra.

    loops_for_dolfinx.py flat_slider|lap_joint FILE [NAME=VALUE ...]

Writes displacement, force, dissipated of every step. flat_slider needs scikit-fem, lap_joint also pypardiso."""

import os
import sys
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
import numpy as np  # noqa: E402


def flat_slider(along=2, quarter=24):
    import host
    import run
    from mepc import Law

    bodies = host.assemble(10 / along)
    table = run.loop(bodies, host.follow(bodies, Law(**run.properties("memory")), run.history(quarter)))
    return table["displacement_1"], table["force_1"], np.diff(table["dissipated_energy"], prepend=0)


def lap_joint(mesh="coarse", quarter=16):
    import paper
    from condense import Moved, condense
    from geometry import MESHES, POISSON, YOUNG, build, supports
    from joint import Case, run

    grid = build(density=MESHES[mesh])
    held, moved = supports(grid)
    structure = condense(grid, held, [Moved(moved, 0)], YOUNG, POISSON, incompatible=False,
                         fixed=[(moved, 1), (moved, 2)], progress=False)
    loop = run(Case("reference", quarter=quarter, **paper.REFERENCE), grid, structure, progress=False)
    return loop.displacement, loop.force, loop.dissipated


def main():
    model, file, *more = sys.argv[1:]
    given = {name: int(value) if value.isdigit() else value for name, value in (text.split("=") for text in more)}
    columns = {"flat_slider": flat_slider, "lap_joint": lap_joint}[model](**given)
    Path(file).parent.mkdir(parents=True, exist_ok=True)
    np.savetxt(file, np.transpose(columns), fmt="%.17g", delimiter=",", header="displacement,force,dissipated",
               comments="")


if __name__ == "__main__":
    main()
