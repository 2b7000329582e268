# SPDX-License-Identifier: MIT OR Apache-2.0
"""A host of one's own: a cube pressed on a flat and moved to and fro, with the contact law called once per iteration.

Elasticity comes from scikit-fem. Only the interface is nonlinear, so both bodies are condensed to the interface nodes
first; what is left is a small dense system, solved by Newton's method. Units: mm, N, MPa."""

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu
from skfem import Basis, ElementHex1, ElementVector, FacetBasis, LinearForm, MeshHex, asm
from skfem.models.elasticity import lame_parameters, linear_elasticity
from tqdm import tqdm

YOUNG, POISSON = 200e3, 0.3
FLAT = ((0, 0, -10), (80, 30, 0))  # opposite corners; its bottom is fixed
CUBE = ((30, 10, 0), (40, 20, 10))  # its top is held by a rigid platen that can move but not turn
LOAD = 1000.0
KN = 1e5  # normal penalty stiffness of the contact


# --- the two bodies ---------------------------------------------------------------------------------------------------


@dataclass
class Bodies:
    """Two elastic bodies reduced to the displacements v that matter: interface nodes, then the platen's x, y, z."""

    stiffness: np.ndarray  # [v, v]
    opening: np.ndarray  # [point, component, v]: opening = cube minus flat; normal first, then x and y
    area: np.ndarray  # [point]
    support: np.ndarray  # [3, v]: reaction of the fixed bottom


def block(corners, size, young, poisson):
    """Mesh, displacement dofs [component, node] and stiffness of a box of hexahedra."""
    axes = [np.linspace(a, b, round((b - a) / size) + 1) for a, b in zip(*corners)]
    mesh = MeshHex.init_tensor(*axes)
    basis = Basis(mesh, ElementVector(ElementHex1()), intorder=2)
    return mesh, basis.nodal_dofs, asm(linear_elasticity(*lame_parameters(young, poisson)), basis)


def assemble(size, young=YOUNG, poisson=POISSON):
    """Builds both bodies with elements of the given size and condenses them."""
    flat, flat_dofs, flat_stiffness = block(FLAT, size, young, poisson)
    cube, cube_dofs, cube_stiffness = block(CUBE, size, young, poisson)
    cube_dofs = cube_dofs + flat_stiffness.shape[0]
    stiffness = sparse.block_diag([flat_stiffness, cube_stiffness], format="csc")

    # Matching nodes: the same order on both sides makes them pairs.
    (x0, y0, z0), (x1, y1, _) = CUBE
    lower = flat.nodes_satisfying(
        lambda x: (x[2] == z0) & (x[0] >= x0 - 1e-9) & (x[0] <= x1 + 1e-9) & (x[1] >= y0 - 1e-9) & (x[1] <= y1 + 1e-9))
    upper = cube.nodes_satisfying(lambda x: x[2] == z0)
    lower, upper = (nodes[np.lexsort(mesh.p[:2, nodes].round(6))] for mesh, nodes in ((flat, lower), (cube, upper)))
    if not np.array_equal(flat.p[:, lower].round(6), cube.p[:, upper].round(6)):
        raise ValueError(f"elements of {size} mm give interface nodes that do not match")
    points = len(upper)

    # Retained displacements, one column each: the interface nodes move singly, the platen moves the whole top.
    interface = np.concatenate([flat_dofs[:, lower].T.ravel(), cube_dofs[:, upper].T.ravel()])
    top = cube_dofs[:, cube.nodes_satisfying(lambda x: x[2] == CUBE[1][2])]
    fixed = flat_dofs[:, flat.nodes_satisfying(lambda x: x[2] == FLAT[0][2])]
    shape = np.zeros((stiffness.shape[0], interface.size + 3))
    shape[interface, np.arange(interface.size)] = 1
    for component in range(3):
        shape[top[component], interface.size + component] = 1

    # All other nodes follow without load: inner = -K_ii^-1 K_ir.
    inner = np.setdiff1d(np.arange(stiffness.shape[0]), np.concatenate([interface, top.ravel(), fixed.ravel()]))
    rows = stiffness[inner]
    shape[inner] = -splu(rows[:, inner].tocsc()).solve(rows @ shape)
    forces = stiffness @ shape
    condensed = shape.T @ forces
    support = np.array([forces[dofs].sum(axis=0) for dofs in fixed])

    opening = np.zeros((points, 3, condensed.shape[0]))
    for row, component in enumerate((2, 0, 1)):
        for point in range(points):
            opening[point, row, 3 * point + component] = -1
            opening[point, row, 3 * (points + point) + component] = 1
    faces = FacetBasis(cube, ElementHex1(), facets=cube.facets_satisfying(lambda x: x[2] == z0), intorder=2)
    area = asm(LinearForm(lambda test, _: test), faces)[upper]
    return Bodies((condensed + condensed.T) / 2, opening, area, support)


# --- equilibrium ------------------------------------------------------------------------------------------------------


class NoEquilibrium(RuntimeError):
    """Newton's method failed even with the smallest step."""


@dataclass
class Equilibrium:
    """An accepted step, and all that a restart needs: displacements and the states of the contact points."""

    displacement: np.ndarray
    state: np.ndarray
    dissipated: float = 0.0  # in this step, N mm
    residuals: list = field(default_factory=list)  # of each Newton loop, rejected ones included


def start(bodies, law):
    """Virgin contact just closed: the cube sinks in by about what the load needs, so that nothing is loose."""
    displacement = np.zeros(len(bodies.stiffness))
    points = len(bodies.area)
    displacement[3 * points + 2::3] = -LOAD / (KN * bodies.area.sum())
    return Equilibrium(displacement, law.virgin(points))


def contact(bodies, law, displacement, state):
    """Forces and stiffness of the interface on v; the new states and the energies."""
    new = law.interface(state, bodies.opening @ displacement)
    rows = bodies.opening.reshape(-1, displacement.size)
    forces = rows.T @ (bodies.area[:, None] * new.traction).ravel()
    stiffness = rows.T @ (bodies.area[:, None, None] * new.tangent @ bodies.opening).reshape(rows.shape)
    return forces, stiffness, new.state, bodies.area @ new.energy


def newton(bodies, law, before, target, tolerance=1e-10 * LOAD, most=20, trials=6):
    """One step to the platen's x = target; every iteration starts from the states before the step.

    Returns the equilibrium, or None if there is none within `most` iterations; and the residual norms."""
    unknown = np.ones(before.displacement.size, bool)
    unknown[[-3, -2]] = False  # the platen's x and y are given, its z carries the load
    displacement = before.displacement.copy()
    displacement[[-3, -2]] = target, 0

    def residual(displacement):
        forces, stiffness, new, energy = contact(bodies, law, displacement, before.state)
        forces += bodies.stiffness @ displacement
        forces[-1] += LOAD
        return forces[unknown], stiffness, new, energy

    force, stiffness, new, energy = residual(displacement)
    norms = [np.linalg.norm(force)]
    while not norms[-1] <= tolerance:  # so written, NaN is no convergence
        if len(norms) > most:
            return None, norms
        jacobian = (bodies.stiffness + stiffness)[np.ix_(unknown, unknown)]
        correction = np.linalg.solve(jacobian, -force)
        # Line search: the residual should fall. At a kink (stick to slip, pressure falling to rising) one side's tangent
        # may lead uphill whatever the length; then the shortest trial stands, and the next tangent is better.
        for halvings in range(trials):
            trial = displacement.copy()
            trial[unknown] += 0.5**halvings * correction
            force, stiffness, new, energy = residual(trial)
            if np.linalg.norm(force) < (1 - 1e-4 * 0.5**halvings) * norms[-1]:
                break
        displacement = trial
        norms.append(np.linalg.norm(force))
    return Equilibrium(displacement, new, energy[1]), norms


def advance(bodies, law, before, target, cuts=6, **options):
    """One step, cut in two if it does not converge. A rejected step leaves no trace: `before` is never written."""
    after, norms = newton(bodies, law, before, target, **options)
    if after is None:
        if cuts == 0:
            raise NoEquilibrium(f"no equilibrium at x = {target}: residual {norms[-1]:.3g} N")
        middle = (before.displacement[-3] + target) / 2
        half = advance(bodies, law, before, middle, cuts - 1, **options)
        after = advance(bodies, law, half, target, cuts - 1, **options)
        after.dissipated += half.dissipated
        after.residuals = [norms] + half.residuals + after.residuals
    else:
        after.residuals = [norms]
    return after


def follow(bodies, law, targets, begin=None, show=None, **options):
    """All steps, as a list of equilibria; `begin` continues an earlier run, `show` names the progress bar."""
    now, done = begin or start(bodies, law), []
    for target in tqdm(targets, desc=show, unit="step", disable=show is None):
        now = advance(bodies, law, now, target, **options)
        done.append(now)
    return done
