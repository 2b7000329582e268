# SPDX-License-Identifier: MIT OR Apache-2.0
"""The contact law in a distributed solver: every pair is evaluated on the rank that owns it, PETSc's SNES does the rest.

Read this one first. structure.py has the elastic bodies; the law is the package mepc."""

import sys
from dataclasses import dataclass, field

from mpi4py import MPI

import numpy as np
from petsc4py import PETSc

from mepc import Law, MepcError
from structure import Structure

TOLERANCE = 1e-8  # N, norm of the residual
ITERATIONS = 20  # of one attempt
LINE_SEARCHES = ("basic", "l2")  # the second when the first fails
CUTS = 8
# Set up once, for the first Jacobian, in which the contact sticks: slip costs some iterations more, far less than a set-up.
MULTIGRID = {"snes_lag_preconditioner": -2, "snes_lag_preconditioner_persists": True,
             "mg_levels_ksp_type": "richardson", "mg_levels_pc_type": "sor"}


class NoEquilibrium(RuntimeError):
    """No line search converged even with the smallest step."""


@dataclass
class Step:
    """An accepted step: all that the next one and a restart need."""

    x: PETSc.Vec  # the unknowns, see structure.py
    state: np.ndarray  # [own pair, nstate]
    load: np.ndarray  # displacement of the moved nodes, interference of the tightened pair
    dissipated: float = 0.0  # in this step by all pairs, N mm
    iterations: int = 0  # of Newton's method, those of attempts that failed included
    linear: int = 0  # of the linear solver, if that is iterative
    cuts: int = 0
    opening: np.ndarray = None  # [own pair, component]
    traction: np.ndarray = None  # [own pair, component]
    residual: PETSc.Vec = field(default=None, repr=False)  # R(u): reactions where displacements are given


class Contact:
    """The own pairs of this rank and the laws of their interfaces. Nothing here is collective."""

    def __init__(self, structure, model):
        self.structure = structure
        self.laws = {name: Law(**props) for name, props in model.props.items()}
        (self.nstate,) = {law.nstate for law in self.laws.values()}
        self.offset = np.zeros(len(structure.own_pairs))
        self.tightened = np.zeros(len(structure.own_pairs))
        for name, part in structure.parts.items():
            self.offset[part] = model.offset.get(name, 0.0)
            self.tightened[part] = -1.0 if name == model.tightened else 0.0

    def virgin(self):
        return np.zeros((len(self.offset), self.nstate))

    def opening(self, displacement, interference):
        """Normal first, positive when open; from displacements [own pair, lower and upper, component]."""
        opening = np.einsum("pij,pj->pi", self.structure.own_frame, displacement[:, 1] - displacement[:, 0])
        opening[:, 0] += self.offset + self.tightened * interference
        return opening

    def evaluate(self, opening, state):
        """Traction, tangent, new state, energy of all own pairs; raises MepcError with the number of the own pair."""
        points = len(opening)
        traction, tangent = np.empty((points, 3)), np.empty((points, 3, 3))
        new, energy = np.empty_like(state), np.empty((points, 2))
        for name, part in self.structure.parts.items():
            try:
                end = self.laws[name].interface(state[part], opening[part])
                traction[part], tangent[part], new[part], energy[part] = end.traction, end.tangent, end.state, end.energy
            except MepcError as refused:
                raise MepcError(str(refused), refused.status, part.start + refused.point) from None
        return traction, tangent, new, energy

    def column(self, name):
        """Place of a state variable."""
        return next(iter(self.laws.values())).state_names.index(name)

    def name(self, own):
        """What a user knows a pair as."""
        structure = self.structure
        for interface, part in structure.parts.items():
            if part.start <= own < part.stop:
                number = structure.own_pairs[own] - structure.first_pair[interface]
                return (f"pair {number} of {interface} (nodes {structure.own_lower[own]} and "
                        f"{structure.own_upper[own]}), rank {structure.comm.rank}")
        raise IndexError(own)


class Solver:
    """Steps of a model: SNES on all ranks, cut in two when it fails.

    linear -- "direct" (MUMPS) or "multigrid" (GMRES behind GAMG)
    say    -- takes a line of text, called on rank 0"""

    def __init__(self, structure, model, linear="direct", say=print):
        self.structure, self.comm, self.model = structure, structure.comm, model
        try:
            self.contact = Contact(structure, model)
            trouble = ""
        except MepcError as error:
            trouble = str(error)
        for trouble in self.comm.allgather(trouble):
            if trouble:
                raise MepcError(trouble, -2)
        self.say = say if self.comm.rank == 0 else lambda text: None
        self._load_on_tied = structure.vector()
        for master, (_, _, force) in zip(structure.masters, model.tied):
            if self.comm.rank == 0:
                self._load_on_tied.setValue(master, force, PETSc.InsertMode.ADD)
        self._load_on_tied.assemble()
        self._before, self._load, self._memo, self._refused = None, None, None, None
        self._events = {name: PETSc.Log.Event(f"mepc {name}") for name in ("law", "scatter", "residual", "jacobian")}
        self._snes(linear)

    # --- what SNES calls ----------------------------------------------------------------------------------------------

    def _law_at(self, u):
        """Opening, traction, tangent, new state, energy at the displacements; None where the library refuses a pair.

        Only the scatter is collective, so that a refusal on one rank leaves no other waiting."""
        with self._events["scatter"]:
            displacement = self.structure.to_pairs(u)
        opening = self.contact.opening(displacement, self._load[1])
        if self._memo is None or not np.array_equal(self._memo[0], opening):
            with self._events["law"]:
                try:
                    self._memo = opening, *self.contact.evaluate(opening, self._before.state)
                except MepcError as refused:
                    self._refused = f"{self.contact.name(refused.point)}: {refused}"
                    self._memo = None
        return self._memo

    def _residual_at(self, x):
        """R(u) without constraints; full of NaN on a rank whose library refuses."""
        structure = self.structure
        u = structure.displacement(x, self._load[0])
        residual = structure.vector()
        structure.elastic.mult(u, residual)
        known = self._law_at(u)
        size = len(structure.own_pairs)
        if known is None:
            forces = np.zeros((size, 3))
        else:
            forces = structure.own_area[:, None] * np.einsum("pij,pi->pj", structure.own_frame, known[1])
        with self._events["scatter"]:
            structure.from_pairs(np.stack([-forces, forces], axis=1), residual)
        if known is None:
            residual.array = np.nan
        return residual

    def _function(self, snes, x, out):
        with self._events["residual"]:
            residual = self._residual_at(x)
            # Filled rows first: x is zero there.
            out.pointwiseMult(self.structure.filler, x)
            out.axpy(-1, self._load_on_tied)
            self.structure.expand.multTransposeAdd(residual, out, out)

    def _jacobian(self, snes, x, matrix, preconditioner):
        with self._events["jacobian"]:
            structure = self.structure
            known = self._law_at(structure.displacement(x, self._load[0]))
            frame = structure.own_frame
            block = np.zeros((len(frame), 6, 6))
            if known is not None:
                one = structure.own_area[:, None, None] * (frame.transpose(0, 2, 1) @ known[2] @ frame)
                block[:, :3, :3] = block[:, 3:, 3:] = one
                block[:, :3, 3:] = block[:, 3:, :3] = -one
            structure.assemble(block, matrix)

    def _snes(self, linear):
        snes = self.snes = PETSc.SNES().create(self.comm)
        snes.setType("newtonls")
        self._out = self.structure.vector()
        snes.setFunction(self._function, self._out)
        matrix = self.structure.jacobian
        snes.setJacobian(self._jacobian, matrix)
        snes.setTolerances(rtol=0, atol=TOLERANCE, stol=0, max_it=ITERATIONS)
        snes.setDivergenceTolerance(-1)
        ksp = snes.getKSP()
        if linear == "direct":
            ksp.setType("preonly")
            ksp.getPC().setType("lu")
            ksp.getPC().setFactorSolverType("mumps")
        elif linear == "multigrid":
            matrix.setNearNullSpace(self.structure.rigid_motions())
            ksp.setType("gmres")
            ksp.setGMRESRestart(100)
            ksp.setTolerances(rtol=1e-6, max_it=500)
            ksp.getPC().setType("gamg")
            options = PETSc.Options()
            for option, value in MULTIGRID.items():
                if not options.hasName(option):
                    options[option] = value
        else:
            raise ValueError(f"linear = {linear!r}: direct or multigrid was expected")
        snes.setFromOptions()  # PETSC_OPTIONS win

    # --- steps --------------------------------------------------------------------------------------------------------

    def start(self):
        """Nothing has touched yet."""
        x = self.structure.vector()
        for nodes, direction, value in self.model.guess:
            x.array[3 * self.structure.find(nodes)[1] + direction] = value
        x.pointwiseMult(x, self.free_places())
        return Step(x, self.contact.virgin(), np.zeros(2))

    def free_places(self):
        """1 where x has an unknown, else 0."""
        flags = self.structure.vector()
        flags.array = self.structure.filler.array_r == 0
        return flags

    def _attempt(self, before, load, search):
        """The step with one line search, or None; and the iterations."""
        snes = self.snes
        snes.getLineSearch().setType(search)
        self._before, self._load, self._memo, self._refused = before, load, None, None
        x = before.x.copy()
        snes.solve(None, x)
        count = snes.getIterationNumber(), snes.getLinearSolveIterations()
        if snes.getConvergedReason() <= 0:
            return None, count
        residual = self._residual_at(x)
        opening, traction, _, new, energy = self._memo
        dissipated = self.comm.allreduce(float(self.structure.own_area @ energy[:, 1]), MPI.SUM)
        return Step(x, new, load, dissipated, *count, 0, opening, traction, residual), count

    def advance(self, before, load, name="", cuts=CUTS):
        """One step, cut in two if it does not converge. A failed one leaves no trace: `before` is never written."""
        wasted, linear = 0, 0
        for search in LINE_SEARCHES:
            after, count = self._attempt(before, load, search)
            if after is not None:
                after.iterations += wasted
                after.linear += linear
                return after
            wasted, linear = wasted + count[0], linear + count[1]
            why = [text for text in self.comm.allgather(self._refused) if text]
            for text in why or [f"SNES reason {self.snes.getConvergedReason()}"]:
                self.say(f"{name}line search {search}, iteration {count[0]}: {text}")
        if cuts == 0:
            raise NoEquilibrium(f"{name}no equilibrium at displacement {load[0]}, interference {load[1]}")
        self.say(f"{name}cut in two")
        half = self.advance(before, (before.load + load) / 2, name, cuts - 1)
        after = self.advance(half, load, name, cuts - 1)
        after.dissipated += half.dissipated
        after.iterations += half.iterations + wasted
        after.linear += half.linear + linear
        after.cuts += half.cuts + 1
        return after

    # --- what is recorded ---------------------------------------------------------------------------------------------

    def row(self, step):
        """Figures of a step, the same on all ranks."""
        structure = self.structure
        reaction = step.residual.array_r[structure.own_moved].sum()
        own = [reaction]
        forces = structure.own_area[:, None] * step.traction
        for part in structure.parts.values():
            own += [-forces[part, 0].sum(), forces[part, 1].sum(), forces[part, 2].sum()]
        own += [np.sum(step.state[:, 0] == number) for number in range(4)]
        total = np.empty(len(own))
        self.comm.Allreduce(np.array(own, float), total)
        names = ["force"]
        for name in structure.parts:
            names += [f"normal_{name}", f"shear_1_{name}", f"shear_2_{name}"]
        names += ["open", "stick", "micro_slip", "gross_slip"]
        return {"displacement": step.load[0], **dict(zip(names, total)), "dissipated": step.dissipated,
                "iterations": step.iterations, "linear_iterations": step.linear, "cuts": step.cuts}

    def normal_force(self, step, interface):
        part = self.structure.parts[interface]
        return self.comm.allreduce(-float(self.structure.own_area[part] @ step.traction[part, 0]), MPI.SUM)


def tighten(solver, increments=4):
    """Equilibrium with the bolt force asked for: the interference is found by the secant method, from virgin contact."""
    model = solver.model

    def force(interference):
        now = solver.start()
        for part in np.arange(1, increments + 1) / increments:
            now = solver.advance(now, np.array([0.0, part * interference]), "tightening: ")
        return now, solver.normal_force(now, model.tightened)

    low, high = 0.8e-5 * model.preload, 0.9e-5 * model.preload  # about 8 um for 900 N
    _, at_low = force(low)
    for _ in range(8):
        now, at_high = force(high)
        solver.say(f"tightening: interference {high:.9g} mm, bolt {at_high:.9g} N")
        if abs(at_high / model.preload - 1) < 1e-6:
            now.dissipated = 0.0  # what tightening took is not the loop's
            return now
        low, high, at_low = high, high + (model.preload - at_high) * (high - low) / (at_high - at_low), at_high
    raise NoEquilibrium(f"no interference gives a preload of {model.preload} N")


def abort_on_error(main):
    """Calls main; an exception on one rank ends all of them, with its text."""
    try:
        status = main()
    except SystemExit:
        raise
    except BaseException:
        import traceback

        traceback.print_exc()
        sys.stderr.flush()
        MPI.COMM_WORLD.Abort(1)
    sys.exit(status)
