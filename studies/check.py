# SPDX-License-Identifier: MIT OR Apache-2.0
"""Checks the studies' finite elements and condensation against closed forms and an uncondensed solution."""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import sys

import numpy as np
from scipy.sparse.linalg import spsolve

from condense import Moved, Pressed, condense
from contact import Contact, Law, Solver
from elasticity import stiffness
from mesh import Builder, rectangles

YOUNG, POISSON = 200e3, 0.3
broken = []


def bound(what, value, limit):
    good = value <= limit
    print(f"{what:70} {value:9.1e}  bound {limit:.0e}  {'ok' if good else 'BROKEN'}")
    if not good:
        broken.append(what)


def block(sizes, divisions):
    x, y, z = (np.linspace(0, size, count + 1) for size, count in zip(sizes, divisions))
    build = Builder(rectangles(x, y, lambda *_: "all"))
    build.extrude("block", ["all"], z)
    return build.mesh()


def patch_test():
    """A linear displacement field loads no inner node, whatever the shape of the elements."""
    sizes = np.array([3.0, 2, 2])
    mesh = block(sizes, (4, 3, 3))
    inner = ((mesh.points > 1e-9) & (mesh.points < sizes - 1e-9)).all(axis=1)
    random = np.random.default_rng(1)
    mesh.points[inner] += 0.3 * (random.random((inner.sum(), 3)) - 0.5)
    gradient = 1e-3 * random.random((3, 3))
    forces = (stiffness(mesh, YOUNG, POISSON) @ (mesh.points @ gradient.T).ravel()).reshape(-1, 3)
    bound("patch test: force on inner nodes over the largest", np.abs(forces[inner]).max() / np.abs(forces).max(), 1e-12)


def bending():
    """A cantilever of ten elements, two over the height, against Timoshenko's beam (shear factor 5/6)."""
    length = 10.0
    mesh = block((length, 1.0, 1.0), (10, 1, 2))
    tip = np.flatnonzero(mesh.points[:, 0] > length - 1e-9)
    clamped = 3 * np.flatnonzero(mesh.points[:, 0] < 1e-9)[:, None] + np.arange(3)
    free = np.setdiff1d(np.arange(3 * len(mesh.points)), clamped)
    beam = length**3 / (3 * YOUNG / 12) + length / (5 / 6 * YOUNG / (2 * (1 + POISSON)))
    matrix = stiffness(mesh, YOUNG, POISSON).tocsc()
    load, answer = np.zeros(matrix.shape[0]), np.zeros(matrix.shape[0])
    load[3 * tip + 2] = 1 / len(tip)
    answer[free] = spsolve(matrix[free][:, free], load[free])
    bound("bending: deflection over the beam's - 1", abs(answer[3 * tip + 2].mean() / beam - 1), 0.03)


def two_blocks():
    """A block on a wider one: pressed, and sheared by its side."""
    build = Builder(rectangles(np.linspace(0, 6, 7), np.linspace(0, 2, 3), lambda x, _: "on" if 1 < x < 4 else "beside"))
    build.extrude("upper", ["on"], [0.0, 1.0, 2.0])
    build.extrude("lower", ["on", "beside"], [-2.0, -1.0, 0.0])
    build.touch("joint", "lower", "upper", ["on"], 0.0)
    return build.mesh()


def condensation():
    """Openings, reaction and displacement conjugate to a force, against all bodies solved with contact springs at once."""
    mesh = two_blocks()
    pair = mesh.pairs[0]
    held = mesh.nodes("lower", lambda x, y, z: z < -2 + 1e-9)
    moved = mesh.nodes("upper", lambda x, y, z: (x > 4 - 1e-9) & (z > 0.5))
    forces = np.zeros((len(mesh.points), 3))
    forces[mesh.nodes("upper", lambda x, y, z: z > 2 - 1e-9), 2] = -1.0
    structure = condense(mesh, held, [Moved(moved, 0), Pressed(forces)], YOUNG, POISSON, progress=False)
    parameters = np.array([1e-3, 5.0])
    springs = np.tile([3e5, 1e5, 1e5], len(pair.area)) * np.repeat(pair.area, 3)
    opening = np.linalg.solve(structure.stiffness + np.diag(springs), structure.loads @ parameters)
    reaction, displacement = structure.conjugate(opening, parameters)

    # All at once: opening = B u with B written down directly.
    matrix = stiffness(mesh, YOUNG, POISSON).toarray()
    rows = np.zeros((len(springs), len(matrix)))
    for point, (lower, upper) in enumerate(zip(pair.lower, pair.upper)):
        rows[3 * point: 3 * point + 3, 3 * upper: 3 * upper + 3] = pair.frame[point]
        rows[3 * point: 3 * point + 3, 3 * lower: 3 * lower + 3] = -pair.frame[point]
    whole = matrix + rows.T * springs @ rows
    given = np.zeros(len(matrix), bool)
    given[3 * held[:, None] + np.arange(3)] = True
    given[3 * moved] = True
    answer = np.zeros(len(matrix))
    answer[3 * moved] = parameters[0]
    load = parameters[1] * forces.ravel() - whole @ answer
    answer[~given] = np.linalg.solve(whole[~given][:, ~given], load[~given])
    bound("condensation: openings", np.abs(rows @ answer - opening).max() / np.abs(opening).max(), 1e-9)
    full = (whole @ answer)[3 * moved].sum()
    bound("condensation: force of the moved nodes", abs(reaction / full - 1), 1e-9)
    bound("condensation: displacement of the loaded ones", abs(displacement / (forces.ravel() @ answer) - 1), 1e-9)


def gross_slip():
    """A block pressed by a force and moved far: its friction is mu N, and the work is the dissipation plus what is stored."""
    mesh = two_blocks()
    held = mesh.nodes("lower", lambda x, y, z: z < -2 + 1e-9)
    top = mesh.nodes("upper", lambda x, y, z: z > 2 - 1e-9)
    forces = np.zeros((len(mesh.points), 3))
    forces[top, 2] = -1.0 / len(top)
    structure = condense(mesh, held, [Moved(top, 0), Pressed(forces)], YOUNG, POISSON, progress=False)
    contact = Contact(mesh.pairs, {"joint": Law(mu=0.3, gcr=2e-3, kn=3e5)})
    contact.offset[:, 0] = -2e-5
    solver = Solver(structure, contact)
    now = solver.start()
    load, path = 500.0, 0.02 * np.concatenate([np.linspace(0, 1, 21), np.linspace(1, -1, 41)[1:], np.linspace(-1, 1, 41)[1:]])
    force, dissipated = [], []
    for displacement in path:
        now = solver.advance(now, np.array([displacement, load]))
        force.append(structure.conjugate(now.opening, now.parameters)[0])
        dissipated.append(now.dissipated)
    bound("gross slip: force over mu N - 1", abs(force[20] / (0.3 * load) - 1), 1e-6)
    area = np.trapezoid(force[20:], path[20:])
    bound("closed cycle: area over the library's dissipation - 1", abs(area / sum(dissipated[21:]) - 1), 2e-2)


if __name__ == "__main__":
    for test in (patch_test, bending, condensation, gross_slip):
        test()
    sys.exit(f"{len(broken)} broken" if broken else 0)
