# SPDX-License-Identifier: MIT OR Apache-2.0
"""From the finite elements of all bodies to a small dense system in the openings of the contact points.

Only the contact is nonlinear. The displacements of the upper node of each pair are replaced by the opening g of the
pair, u_upper = u_lower + g; with g held the bodies are glued together, so that what remains is positive definite, has
one sparse factor, and is eliminated. What is left, with contact forces f(g) and load parameters a, is

    S g + f(g) = F a

One S serves every preload, friction coefficient, amplitude and contact law."""

import hashlib
import warnings
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from pypardiso import PyPardisoSolver
from tqdm import tqdm

from elasticity import stiffness

BLOCK = 256  # right-hand sides at a time


@dataclass
class Moved:
    """A load case: displacements, per unit of its parameter, of components of nodes; all else about them is free."""

    nodes: np.ndarray
    direction: int


@dataclass
class Pressed:
    """A load case: nodal forces [node, 3] per unit of its parameter."""

    forces: np.ndarray


@dataclass
class Interface:
    """The condensed structure. Openings are numbered 3 point + component: normal, then the two tangents."""

    stiffness: np.ndarray  # S [opening, opening], N/mm
    loads: np.ndarray  # F [opening, case]
    direct: np.ndarray  # [case, case]: see conjugate
    sign: np.ndarray  # [case]: -1 for a displacement, 1 for a force

    def conjugate(self, opening, parameters):
        """What does work on each load parameter: the force of a displacement, the displacement of a force."""
        return self.sign * (self.loads.T @ opening) + self.direct @ parameters


class Factor:
    """Cholesky factor of a sparse positive definite matrix (MKL PARDISO)."""

    def __init__(self, matrix):
        self._solver = PyPardisoSolver(mtype=2)
        self._upper = sparse.triu(matrix, format="csr")
        self._solver.factorize(self._upper)

    def solve(self, right):
        with warnings.catch_warnings():  # it converts to columns by itself, and says so
            warnings.simplefilter("ignore")
            return self._solver.solve(self._upper, right)

    def free(self):
        self._solver.free_memory(everything=True)


def openings(mesh):
    """T, sparse: displacements of all nodes from (displacements with those of the upper nodes left out, openings).

    Returns T_w [dof, dof] with empty columns for the upper nodes, and T_g [dof, opening]."""
    lower = np.concatenate([pair.lower for pair in mesh.pairs])
    upper = np.concatenate([pair.upper for pair in mesh.pairs])
    frame = np.concatenate([pair.frame for pair in mesh.pairs])
    if len(np.unique(upper)) < len(upper) or np.isin(upper, lower).any():
        raise ValueError("a node is in two pairs, and the upper one in one of them")
    size = 3 * len(mesh.points)
    dofs_lower, dofs_upper = (3 * nodes[:, None] + np.arange(3) for nodes in (lower, upper))
    kept = np.ones(size)
    kept[dofs_upper] = 0
    glue = sparse.coo_array((np.ones(dofs_upper.size), (dofs_upper.ravel(), dofs_lower.ravel())), (size, size))
    # u_upper = u_lower + sum_c g_c frame_c
    rows = np.repeat(dofs_upper[:, None, :], 3, axis=1)
    columns = np.repeat(np.arange(3 * len(lower)).reshape(-1, 3, 1), 3, axis=2)
    open_up = sparse.coo_array((frame.ravel(), (rows.ravel(), columns.ravel())), (size, 3 * len(lower)))
    return (sparse.diags_array(kept) + glue).tocsr(), open_up.tocsr()


def condense(mesh, held, cases, young=200e3, poisson=0.3, incompatible=True, fixed=(), progress=True):
    """Condenses the bodies to their contact points.

    held  -- nodes that do not move
    cases -- the load cases
    fixed -- (nodes, direction): components that do not move"""
    matrix = stiffness(mesh, young, poisson, incompatible)
    keep, open_up = openings(mesh)
    size = matrix.shape[0]

    # Prescribed displacements [dof, case], nodal forces [dof, case].
    prescribed, forces = np.zeros((size, len(cases))), np.zeros((size, len(cases)))
    given = np.zeros(size, bool)
    for nodes, direction in [*((held, direction) for direction in range(3)), *fixed]:
        given[3 * nodes + direction] = True
    for number, case in enumerate(cases):
        if isinstance(case, Moved):
            given[3 * case.nodes + case.direction] = True
            prescribed[3 * case.nodes + case.direction, number] = 1
        else:
            forces[:, number] = case.forces.ravel()
    upper = keep.diagonal() == 0
    if (given & upper).any():
        raise ValueError("a displacement is prescribed at the upper node of a pair: make its body the lower one")
    free = np.flatnonzero(~given & ~upper)

    glued, mixed, opened = keep.T @ matrix @ keep, keep.T @ matrix @ open_up, open_up.T @ matrix @ open_up
    rows, glued_free = mixed.tocsr()[free], glued.tocsr()[free]
    factor = Factor(glued_free[:, free])
    # Loads on the free displacements and on the openings, with the openings held.
    load = (keep.T @ forces)[free] - glued_free @ prescribed
    answer = factor.solve(load)
    loads = open_up.T @ forces - mixed.T @ prescribed - rows.T @ answer
    moved = np.array([isinstance(case, Moved) for case in cases])
    direct = np.where(
        moved[:, None],
        prescribed.T @ (glued @ prescribed) - load.T @ answer,
        load.T @ answer + (keep.T @ forces).T @ prescribed,
    )
    reduced = opened.toarray()
    columns = rows.tocsc()
    starts = range(0, reduced.shape[1], BLOCK)
    for start in tqdm(starts, desc="condensing", unit=f"x{BLOCK}", disable=not progress):
        block = slice(start, start + BLOCK)
        reduced[:, block] -= rows.T @ factor.solve(np.asfortranarray(columns[:, block].toarray()))
    factor.free()
    return Interface((reduced + reduced.T) / 2, loads, direct, np.where(moved, -1.0, 1.0))


def cached(file, key, make):
    """The interface that `make` gives, from the file if that was made for the same key (any repr)."""
    digest = hashlib.sha256(repr(key).encode()).hexdigest()
    if file.exists():
        with np.load(file) as stored:
            if str(stored["digest"]) == digest:
                return Interface(*(stored[name] for name in ("stiffness", "loads", "direct", "sign")))
    made = make()
    file.parent.mkdir(parents=True, exist_ok=True)
    np.savez(file, digest=digest, **vars(made))
    return made
