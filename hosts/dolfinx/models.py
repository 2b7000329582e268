# SPDX-License-Identifier: MIT OR Apache-2.0
"""What is to be solved: meshes with doubled nodes, pairs of them that touch, supports, loads, history. mm, N, MPa.

Nodes are numbered as in the arrays of the mesh (input numbers), whatever the partition. Only rank 0 needs the mesh;
what lies on surfaces is known to all ranks."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

import geometry
import paper
from mesh import Pair

ROOT = Path(__file__).resolve().parents[2]


@dataclass
class Model:
    """A structure of several bodies in contact, and how it is moved."""

    key: dict  # what the model was made from: a restart must be given the same
    pairs: list  # of studies/mesh.py's Pair
    props: dict  # keywords of the law, by the pair's name
    young: float
    poisson: float
    fixed: list  # (nodes, direction): displacements that are zero
    moved: tuple  # (nodes, direction): displacements that follow the history
    tied: list = field(default_factory=list)  # (nodes, direction, force): move alike; the force acts on all together
    guess: list = field(default_factory=list)  # (nodes, direction, displacement) before the first step
    offset: dict = field(default_factory=dict)  # added to the normal opening, by the pair's name; 0 if not given
    tightened: str = ""  # the pair whose interference gives the bolt its force
    preload: float = 0.0  # of that bolt
    history: np.ndarray = None  # displacements of the moved nodes, step by step
    points: np.ndarray = None  # [node, 3], on rank 0 only
    hexahedra: np.ndarray = None  # [element, 8], the order of VTK, on rank 0 only
    body: np.ndarray = None  # [element] number of the body, on rank 0 only


def shared(comm, make):
    """The model that `make` gives on rank 0; on the others without the mesh."""
    model = make() if comm.rank == 0 else None
    rest = comm.bcast(model and replace(model, points=None, hexahedra=None, body=None))
    return model or rest


def graded(start, end, steps):
    """Fine after the start, where the contact is stiffest."""
    return start + (end - start) * (np.arange(1, steps + 1) / steps) ** 1.5


def swing(amplitude, quarter):
    """First loading to +A in `quarter` steps, to -A and back in twice as many each."""
    a = amplitude
    return np.concatenate([graded(0, a, quarter), graded(a, -a, 2 * quarter), graded(-a, a, 2 * quarter)])


# --- flat and slider: the model of hosts/scikit_fem ---------------------------------------------------------------------


def box(corners, elements):
    """A box of hexahedra: points, hexahedra, and the node numbers by position."""
    axes = [np.linspace(a, b, n + 1) for a, b, n in zip(*corners, elements)]
    number = np.arange(np.prod([len(axis) for axis in axes])).reshape([len(axis) for axis in axes])
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    a, b = slice(None, -1), slice(1, None)
    around = [(a, a), (b, a), (b, b), (a, b)]
    hexahedra = np.stack([number[x, y, z] for z in (a, b) for x, y in around], axis=-1).reshape(-1, 8)
    return points, hexahedra, number


def flat_slider(along=2, quarter=24, method="memory", mu=0.43, gcr=2e-3, chi=2.5, load=1000.0, amplitude=0.02, kn=1e5,
                reference_pressure=10.0):
    """A cube of 10 mm with `along` elements per edge on a flat of 80 x 30 x 10 mm whose bottom is fixed. A rigid platen
    holds the cube's top; it does not turn, presses with the load and moves along x."""
    size = 10.0 / along
    flat, flat_hexahedra, flat_number = box(((0, 0, -10), (80, 30, 0)), (8 * along, 3 * along, along))
    cube, cube_hexahedra, cube_number = box(((30, 10, 0), (40, 20, 10)), (along, along, along))
    cube_number = cube_number + len(flat)
    lower = flat_number[3 * along:4 * along + 1, along:2 * along + 1, -1].ravel()
    upper = cube_number[:, :, 0].ravel()
    grid = np.arange(len(lower)).reshape(along + 1, along + 1)
    faces = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=-1).reshape(-1, 4)
    area = np.bincount(faces.ravel(), minlength=len(lower)) * size**2 / 4
    frame = np.tile([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]], (len(lower), 1, 1))
    top = cube_number[:, :, -1].ravel()
    held = flat_number[:, :, 0].ravel()
    return Model(
        key=dict(model="flat_slider", along=along, quarter=quarter, method=method, mu=mu, gcr=gcr, chi=chi, load=load,
                 amplitude=amplitude, kn=kn, reference_pressure=reference_pressure),
        pairs=[Pair("contact", lower, upper, area, frame, faces)],
        props={"contact": dict(mu=mu, gcr=gcr, exponent=chi, method=method, kn=kn, reference_pressure=reference_pressure)},
        young=200e3, poisson=0.3,
        fixed=[*((held, direction) for direction in range(3)), (top, 1)],
        moved=(top, 0),
        tied=[(top, 2, -load)],
        # The cube starts a little sunk in, so that nothing is loose.
        guess=[(cube_number.ravel(), 2, -load / (kn * area.sum()))],
        history=np.concatenate([[0.0], swing(amplitude, quarter)]),
        points=np.vstack([flat, cube]),
        hexahedra=np.vstack([flat_hexahedra, cube_hexahedra + len(flat)]),
        body=np.repeat([0, 1], [len(flat_hexahedra), len(cube_hexahedra)]),
    )


# --- lap joint: the model of studies/lap_joint, with plain hexahedra ------------------------------------------------------

SEED = 2e-5  # mm of interference in every pair, so that no body is loose at the first step


def lap_joint(mesh="coarse", quarter=16, method="memory", mu=0.3, gcr=2.68e-3, chi=2.5, preload=900.0, amplitude=0.02,
              kn=3e5, reference_pressure=0.0):
    """The bolted joint: first tightened until the bolt has its preload, then the end of the moving plate is moved."""
    grid = geometry.build(density=geometry.MESHES[mesh])
    held, moved = geometry.supports(grid)
    plates, others = (dict(mu=mu, gcr=gcr, exponent=exponent, method=name, kn=kn, reference_pressure=reference_pressure)
                      for exponent, name in ((chi, method), (1.0, "penalty")))
    bodies = sorted(set(grid.body))
    return Model(
        key=dict(model="lap_joint", mesh=mesh, quarter=quarter, method=method, mu=mu, gcr=gcr, chi=chi, preload=preload,
                 amplitude=amplitude, kn=kn, reference_pressure=reference_pressure),
        pairs=grid.pairs,
        props={pair.name: plates if pair.name == "plate-plate" else others for pair in grid.pairs},
        young=geometry.YOUNG, poisson=geometry.POISSON,
        fixed=[*((held, direction) for direction in range(3)), (moved, 1), (moved, 2)],
        moved=(moved, 0),
        offset={pair.name: -SEED for pair in grid.pairs},
        tightened="head-washer", preload=preload,
        history=swing(amplitude, quarter),
        points=grid.points, hexahedra=grid.hexahedra, body=np.searchsorted(bodies, grid.body),
    )


MODELS = {"flat_slider": flat_slider, "lap_joint": lap_joint}


def table_1(**more):
    """The paper's 13 distinct cases of the lap joint: name and arguments."""
    first = {**paper.REFERENCE, **more}
    return {
        **{f"P{preload}": {**first, "preload": preload} for preload in paper.PRELOAD},
        **{f"mu{mu}": {**first, "mu": mu} for mu in paper.FRICTION if mu != paper.REFERENCE["mu"]},
        **{f"A{a:.3f}": {**first, "amplitude": a} for a in paper.AMPLITUDE if a != paper.REFERENCE["amplitude"]},
    }
