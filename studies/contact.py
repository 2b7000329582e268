# SPDX-License-Identifier: MIT OR Apache-2.0
"""Equilibrium of the condensed structure with the contact law of libmepc.so, step by step."""

from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse.linalg import LinearOperator, gmres

from mepc import Law


class NoEquilibrium(RuntimeError):
    """Newton's method failed even with the smallest step."""


def parts(pairs):
    """Where the points of each pair stand in arrays over all points, by name."""
    ends = np.cumsum([len(pair.area) for pair in pairs])
    return {pair.name: slice(end - len(pair.area), end) for pair, end in zip(pairs, ends)}


class Contact:
    """The contact points of a mesh, a law for each pair."""

    def __init__(self, pairs, laws):
        self.area = np.concatenate([pair.area for pair in pairs])
        self.parts = parts(pairs)
        self.laws = {name: laws[name] for name in self.parts}
        self.offset = np.zeros((len(self.area), 3))  # added to the opening: clearance, or negative interference

    def virgin(self):
        return {name: law.virgin(len(self.area[self.parts[name]])) for name, law in self.laws.items()}

    def evaluate(self, opening, states):
        """Forces [3 point], stiffness [point, 3, 3], new states and dissipated energy of this step (N mm)."""
        opening = opening.reshape(-1, 3) + self.offset
        forces, stiffness = np.empty_like(opening), np.empty((len(opening), 3, 3))
        new, dissipated = {}, 0.0
        for name, law in self.laws.items():
            part = self.parts[name]
            end = law.interface(states[name], opening[part])
            area, new[name] = self.area[part], end.state
            forces[part] = area[:, None] * end.traction
            stiffness[part] = area[:, None, None] * end.tangent
            dissipated += area @ end.energy[:, 1]
        return forces.ravel(), stiffness, new, dissipated


@dataclass
class Equilibrium:
    """An accepted step: openings, contact forces, the states of the law by pair."""

    parameters: np.ndarray
    opening: np.ndarray
    forces: np.ndarray
    states: dict
    dissipated: float = 0.0  # in this step
    iterations: int = 0


@dataclass
class Solver:
    """Newton's method on the openings, with line search and step halving."""

    interface: object
    contact: Contact
    tolerance: float = 1e-6  # N, norm of the residual
    iterations: int = 25
    cuts: int = 8
    _factor: tuple = field(default=None, repr=False)

    def start(self):
        size = len(self.interface.stiffness)
        parameters = np.zeros(self.interface.loads.shape[1])
        return Equilibrium(parameters, np.zeros(size), np.zeros(size), self.contact.virgin())

    def _newton_step(self, stiffness, residual):
        """Solves (S + contact stiffness) x = -residual: by GMRES behind an old factor while that is good."""
        interface = self.interface.stiffness

        def apply(x):
            return interface @ x + np.einsum("pij,pj->pi", stiffness, x.reshape(-1, 3)).ravel()

        if self._factor is not None:
            size = residual.size
            step, failed = gmres(
                LinearOperator((size, size), apply), -residual, rtol=1e-5, restart=30, maxiter=1,
                M=LinearOperator((size, size), lambda x: lu_solve(self._factor, x, check_finite=False)))
            if not failed:
                return step
        matrix = interface.copy()
        points = np.arange(0, residual.size, 3)
        for i in range(3):
            for j in range(3):
                matrix[points + i, points + j] += stiffness[:, i, j]
        self._factor = lu_factor(matrix, overwrite_a=True, check_finite=False)
        return lu_solve(self._factor, -residual, check_finite=False)

    def _newton(self, before, parameters):
        """The equilibrium at the parameters, or None."""
        interface, contact = self.interface, self.contact
        load = interface.loads @ parameters

        def residual(opening):
            forces, stiffness, new, dissipated = contact.evaluate(opening, before.states)
            return interface.stiffness @ opening + forces - load, forces, stiffness, new, dissipated

        opening = before.opening
        rest, forces, stiffness, new, dissipated = residual(opening)
        norm = np.linalg.norm(rest)
        for iteration in range(self.iterations + 1):
            if norm <= self.tolerance:
                return Equilibrium(parameters, opening, forces, new, dissipated, iteration)
            step = self._newton_step(stiffness, rest)
            # Shorter while the residual grows. At a kink no length may be better; then the shortest stands.
            for length in 0.5 ** np.arange(6):
                trial = opening + length * step
                rest, forces, stiffness, new, dissipated = residual(trial)
                trial_norm = np.linalg.norm(rest)
                if trial_norm < (1 - 1e-4 * length) * norm:
                    break
            opening, norm = trial, trial_norm
        return None

    def advance(self, before, parameters, cuts=None):
        """One step, halved if it does not converge. A failed step leaves no trace."""
        cuts = self.cuts if cuts is None else cuts
        after = self._newton(before, parameters)
        if after is None:
            self._factor = None
            if cuts == 0:
                raise NoEquilibrium(f"no equilibrium at {parameters}")
            half = self.advance(before, (before.parameters + parameters) / 2, cuts - 1)
            after = self.advance(half, parameters, cuts - 1)
            after.dissipated += half.dissipated
            after.iterations += half.iterations + self.iterations
        return after
