# SPDX-License-Identifier: MIT OR Apache-2.0
"""The bolted lap joint: condensed structure, tightening of the bolt, and one hysteresis loop. Millimetres and newtons."""

from dataclasses import dataclass

import numpy as np
from tqdm import tqdm

from condense import Moved, cached, condense
from contact import Contact, Law, NoEquilibrium, Solver
from geometry import POISSON, YOUNG, Density, Geometry, build, supports
from loops import cycle


def interface(file, geometry=Geometry(), density=Density(), incompatible=True, progress=True):
    """Mesh and condensed structure of the joint, from the file if it holds them. One load case: the end that moves."""
    mesh = build(geometry, density)
    held, moved = supports(mesh, geometry)

    def make():
        return condense(
            mesh, held, [Moved(moved, 0)], YOUNG, POISSON, incompatible, fixed=[(moved, 1), (moved, 2)],
            progress=progress)

    return mesh, cached(file, (geometry, density, incompatible), make)


@dataclass(frozen=True)
class Case:
    """One hysteresis loop: how hard the bolt is tightened, what the contact is, how far the end goes to and fro."""

    name: str
    preload: float  # N, in the bolt after tightening
    mu: float
    amplitude: float  # mm, of the moved end
    method: str = "memory"  # on plate-plate: memory, penalty or Lagrange; the other pairs take the standard penalty
    gcr: float = 2.68e-3  # elastic slip: .4 % of a contact length of .67 mm
    chi: float = 2.5
    kn: float = 3e5  # N/mm3
    reference_pressure: float = 0.0  # MPa; 0 is the proportional rule, the paper's
    quarter: int = 16  # increments of a quarter cycle, of 80 in all

    def laws(self, pairs):
        """The library's law for each pair. Preload and opening history make the rest."""
        def law(method, chi):
            return Law(mu=self.mu, gcr=self.gcr, exponent=chi, method=method.lower(), kn=self.kn,
                       reference_pressure=self.reference_pressure)

        plates, others = law(self.method, self.chi if self.method == "memory" else 1.0), law("penalty", 1.0)
        return {pair.name: plates if pair.name == "plate-plate" else others for pair in pairs}


SEED = 2e-5  # mm of interference in every pair, so that no body is loose at the first step


def tighten(solver, preload, increments=4):
    """Equilibrium with the bolt force asked for: the interference under the head is found by the secant method."""
    contact = solver.contact
    head = contact.parts["head-washer"]

    def force(interference):
        contact.offset[:, 0] = -SEED
        now = solver.start()
        for part in np.arange(1, increments + 1) / increments:
            contact.offset[head, 0] = -SEED - part * interference
            now = solver.advance(now, np.zeros(1))
        return now, bolt_force(contact, now)

    low, high = 0.8e-5 * preload, 0.9e-5 * preload  # about 8 um for 900 N
    _, at_low = force(low)
    for _ in range(8):
        now, at_high = force(high)
        if abs(at_high / preload - 1) < 1e-6:
            return now
        low, high, at_low = high, high + (preload - at_high) * (high - low) / (at_high - at_low), at_high
    raise NoEquilibrium(f"no interference gives a preload of {preload} N")


def bolt_force(contact, now):
    """Normal force under the head, N."""
    return -now.forces.reshape(-1, 3)[contact.parts["head-washer"], 0].sum()


@dataclass
class Loop:
    """A history: one entry per increment, the tightened joint first."""

    displacement: np.ndarray  # of the moved end, mm
    force: np.ndarray  # on it, N
    bolt: np.ndarray  # force under the head, N
    dissipated: np.ndarray  # in the increment by all pairs, N mm
    iterations: np.ndarray
    steps: list  # the equilibria

    def last_cycle(self):
        """Positions from the first turn at +A to the last."""
        return slice(int(np.argmax(self.displacement)), None)

    def area(self):
        """Energy that a cycle takes, N mm."""
        cycle = self.last_cycle()
        return np.trapezoid(self.force[cycle], self.displacement[cycle])


def run(case, mesh, structure, progress=True):
    """The loop of a case."""
    contact = Contact(mesh.pairs, case.laws(mesh.pairs))
    solver = Solver(structure, contact)
    steps = [tighten(solver, case.preload)]
    steps[0].dissipated = 0.0  # what tightening took is not the loop's
    for displacement in tqdm(
            cycle(case.amplitude, case.quarter), desc=case.name, unit="step", leave=False, disable=not progress):
        steps.append(solver.advance(steps[-1], np.array([displacement])))
    return Loop(
        np.array([step.parameters[0] for step in steps]),
        np.array([structure.conjugate(step.opening, step.parameters)[0] for step in steps]),
        np.array([bolt_force(contact, step) for step in steps]),
        np.array([step.dissipated for step in steps]),
        np.array([step.iterations for step in steps]),
        steps,
    )
