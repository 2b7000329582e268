# SPDX-License-Identifier: MIT OR Apache-2.0
"""The contact law: properties by name, updates of many points, whole histories."""

from __future__ import annotations

import ctypes
import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ._library import LIBRARY, MepcError, MepcWarning, address, checked, reals

if TYPE_CHECKING:  # NumPy 1.19 has no such module
    from numpy.typing import ArrayLike

#: Names of the properties, in the order of PROPS.
PROPERTIES = (
    "mu", "gcr", "exponent", "method", "reference_pressure", "fraction", "kn", "gap0", "normal_exponent", "backbone",
    "beta", "cohesion", "tau_max", "mu_late", "slip_late", "resolution",
)
_METHODS = {"memory": 0.0, "penalty": 1.0, "lagrange": 2.0}
_BACKBONES = {"power_law": 0.0, "segalman": 1.0}
_FULL = "the memory of {} of {} points was full: the least important knot went; a longer state (nstate) keeps more"


class Update(NamedTuple):
    """What `Law.update` gives. The leading axes are those of the states; without a direction axis in `slip`, the
    directions are left out here, too."""

    traction: np.ndarray  #: [.., ndir] friction traction, force per area, with the sign of the slip
    state: np.ndarray  #: [.., nstate] at the end of the increment
    dtraction_dslip: np.ndarray | None  #: [.., ndir, ndir] d traction_i / d slip_j
    dtraction_dpressure: np.ndarray | None  #: [.., ndir]
    energy: np.ndarray  #: [.., 2] per area: stored at the end, dissipated in the increment
    statuses: np.ndarray  #: [..] 0, or 1 where the memory was full


class Interface(NamedTuple):
    """What `Law.interface` gives; the leading axes are those of the states."""

    traction: np.ndarray  #: [.., 1 + ndir] normal first (negative in compression), force per area
    state: np.ndarray  #: [.., nstate] at the end of the increment
    tangent: np.ndarray | None  #: [.., 1 + ndir, 1 + ndir] d traction_i / d opening_j, not symmetric
    energy: np.ndarray  #: [.., 2] per area: stored at the end (the normal spring included), dissipated in the increment
    statuses: np.ndarray  #: [..] 0, or 1 where the memory was full


class History(NamedTuple):
    """What `Law.history` gives for n increments; further leading axes where there are several points."""

    traction: np.ndarray  #: [.., n, ndir] after each increment
    state: np.ndarray  #: [.., nstate] after the last one
    energy: np.ndarray | None  #: [.., n, 2] per area: stored, dissipated in the increment
    dtraction_dslip: np.ndarray | None  #: [.., n, ndir, ndir], on request
    dtraction_dpressure: np.ndarray | None  #: [.., n, ndir], on request


class Law:
    """Friction with memory at contact points, for one set of properties.

    A law is immutable and may be shared by threads; what a contact remembers is in the states, which belong to the
    caller. Any consistent set of units (mm, N, MPa): tractions and pressures are force per area, compression is
    positive pressure. The names are those of the property table; 0 stands for the default of each.

    Args:
        mu: friction coefficient, >= 0.
        gcr: critical (elastic) slip at the reference pressure, length, > 0.
        exponent: power law: chi >= 1, default 2.5. Segalman's backbone: q in (1, 2], required.
        method: "memory", "penalty" (chi = 1) or "lagrange" (here the penalty method with gcr / 1000), or 0, 1, 2.
        reference_pressure: pressure at which gcr holds, > 0 for the consistent rule under changing pressure
            (recommended); 0 for the proportional rule, which can create energy.
        fraction: of no use here, since there is no characteristic length.
        kn: normal stiffness, force per volume; > 0 required by `interface`.
        gap0: initial clearance, length; negative is interference.
        normal_exponent: p = kn * closure ** normal_exponent, >= 1, default 1.
        backbone: "power_law" or "segalman", or 0, 1.
        beta: Segalman's stiffness ratio, >= 0.
        cohesion: traction that a closed contact bears without pressure, >= 0.
        tau_max: cap of the limit traction; 0 for none.
        mu_late, slip_late: friction coefficient after long slip, and the slip length over which mu goes there (1/e).
        resolution: how fine a turning path is kept in two directions, 1e-6 to 0.1, default 1e-3.
        ndir: tangential directions, 1 or 2.
        nstate: numbers in a state, default the library's (44 for one direction, 84 for two).
        threads: threads of the calls for many points: 1, another number, or 0 for as many as there are cores.

    Raises:
        MepcError: a property is out of range; the text names it, its value and the range.
    """

    def __init__(
        self,
        mu: float = 0.0,
        gcr: float = 0.0,
        exponent: float = 0.0,
        method: str | float = 0.0,
        reference_pressure: float = 0.0,
        fraction: float = 0.0,
        kn: float = 0.0,
        gap0: float = 0.0,
        normal_exponent: float = 0.0,
        backbone: str | float = 0.0,
        beta: float = 0.0,
        cohesion: float = 0.0,
        tau_max: float = 0.0,
        mu_late: float = 0.0,
        slip_late: float = 0.0,
        resolution: float = 0.0,
        *,
        ndir: int = 2,
        nstate: int | None = None,
        threads: int = 1,
    ) -> None:
        self._make(
            [
                mu, gcr, exponent, _number("method", method, _METHODS), reference_pressure, fraction, kn, gap0,
                normal_exponent, _number("backbone", backbone, _BACKBONES), beta, cohesion, tau_max, mu_late, slip_late,
                resolution,
            ],
            ndir, nstate, threads,
        )

    @classmethod
    def from_props(cls, props: ArrayLike, *, ndir: int = 2, nstate: int | None = None, threads: int = 1) -> Law:
        """A law from PROPS, the array that decks and the C interface take; missing trailing entries are defaults."""
        law = cls.__new__(cls)
        law._make(props, ndir, nstate, threads)
        return law

    def _make(self, props: ArrayLike, ndir: int, nstate: int | None, threads: int) -> None:
        self._law = ctypes.c_void_p()
        self._props = reals("props", props).ravel()
        self._ndir, self._threads = int(ndir), int(threads)
        numbers = address(self._props), self._props.size, self._ndir
        if nstate is None:
            nstate = checked(LIBRARY.mepc_state_size(*numbers))
        self._nstate = int(nstate)
        checked(LIBRARY.mepc_law_new(*numbers, self._nstate, ctypes.byref(self._law)))

    def __del__(self) -> None:
        law = getattr(self, "_law", None)
        if law:
            LIBRARY.mepc_law_free(law)

    def __reduce__(self) -> Any:
        return _again, (self._props, self._ndir, self._nstate, self._threads)

    def __repr__(self) -> str:
        given = [f"{name}={value:g}" for name, value in zip(PROPERTIES, self._props) if value]
        return f"Law({', '.join(given + [f'ndir={self._ndir}'])})"

    @property
    def props(self) -> np.ndarray:
        """The properties as PROPS, for a deck: a copy, without trailing defaults."""
        used = np.flatnonzero(self._props)
        return self._props[: used[-1] + 1 if used.size else 0].copy()

    @property
    def ndir(self) -> int:
        """Tangential directions, 1 or 2."""
        return self._ndir

    @property
    def nstate(self) -> int:
        """Numbers in the state of a point."""
        return self._nstate

    @property
    def state_names(self) -> list[str]:
        """The names of the numbers in a state, in their order."""
        return [LIBRARY.mepc_state_name(self._law, index).decode() for index in range(self._nstate)]

    def virgin(self, *points: int) -> np.ndarray:
        """States of points that were never closed: zeros [*points, nstate]."""
        return np.zeros((*points, self._nstate))

    def update(
        self,
        states: ArrayLike,
        slip: ArrayLike,
        pressure: ArrayLike,
        mu_factor: ArrayLike | None = None,
        *,
        tangents: bool = True,
        out: Update | None = None,
    ) -> Update:
        """One increment of one point or of many, in the friction form.

        Args:
            states: [.., nstate] at the start of the increment, `virgin()` before the first; left as they are.
            slip: [.., ndir] tangential slip of the increment, length; for one direction [..] will do.
            pressure: [..] or one number, at the end of the increment, positive in compression; an open contact has 0.
            mu_factor: [..] or one number that multiplies mu, default 1.
            tangents: whether the derivatives are wanted.
            out: an earlier result whose arrays are written again, which saves the making of new ones. Its state may be
                the array `states`.

        Raises:
            MepcError: a point was refused; nothing of it was written. The text names the point and the cause.
        """
        states, lead = self._states(states)
        slip, axes = self._directions("slip", slip, lead)
        pressure = reals("pressure", pressure, lead)
        if mu_factor is not None:
            mu_factor = reals("mu_factor", mu_factor, lead)
        shapes = [lead + axes, states.shape, lead + axes + axes, lead + axes, (*lead, 2)]
        wanted = [True, True, tangents, tangents, True]
        arrays, statuses = _outputs(out, shapes, wanted, lead)
        traction, state, dslip, dpressure, energy = arrays
        status = checked(LIBRARY.mepc_friction_batch(
            self._law, statuses.size, address(slip), address(pressure), address(mu_factor), address(states),
            address(state), address(traction), address(dslip), address(dpressure), address(energy), address(statuses),
            self._threads), statuses)
        _tell(status, statuses)
        return Update(traction, state, dslip, dpressure, energy, statuses)

    def interface(
        self,
        states: ArrayLike,
        opening: ArrayLike,
        mu_factor: ArrayLike | None = None,
        *,
        tangents: bool = True,
        out: Interface | None = None,
    ) -> Interface:
        """One increment of one point or of many, in the interface form: normal penalty (`kn`) and friction.

        Args:
            states: [.., nstate] at the start of the increment, `virgin()` before the first; left as they are.
            opening: [.., 1 + ndir] total opening at the end of the increment, normal first, positive when open.
            mu_factor, tangents, out: as in `update`.
        """
        states, lead = self._states(states)
        size = 1 + self._ndir
        opening = _exact("opening", opening, (*lead, size))
        if mu_factor is not None:
            mu_factor = reals("mu_factor", mu_factor, lead)
        shapes = [opening.shape, states.shape, (*lead, size, size), (*lead, 2)]
        arrays, statuses = _outputs(out, shapes, [True, True, tangents, True], lead)
        traction, state, tangent, energy = arrays
        status = checked(LIBRARY.mepc_interface_batch(
            self._law, statuses.size, address(opening), address(mu_factor), address(states), address(state),
            address(traction), address(tangent), address(energy), address(statuses), self._threads), statuses)
        _tell(status, statuses)
        return Interface(traction, state, tangent, energy, statuses)

    def history(
        self,
        slip: ArrayLike,
        pressure: ArrayLike,
        mu_factor: ArrayLike | None = None,
        *,
        state: ArrayLike | None = None,
        energy: bool = True,
        tangents: bool = False,
    ) -> History:
        """A whole history of one point, or the histories of many, in one call.

        Args:
            slip: [n, ndir] slip of each increment, length; [points, n, ndir] (or more leading axes) for many points.
                For one direction the last axis may be left out; an array that has one of length 1 keeps it.
            pressure: [.., n] at the end of each increment, or anything that NumPy repeats to that.
            mu_factor: the same, multiplies mu; default 1.
            state: [nstate] or [points, nstate] before the first increment, default never closed; left as it is.
            energy: whether the energies are wanted.
            tangents: whether the derivatives are wanted.

        Raises:
            MepcError: an increment was refused; the text names it and the cause.
        """
        slip = reals("slip", slip)
        bare = self._ndir == 1 and (slip.ndim < 2 or slip.shape[-1] != 1)
        axes: tuple[int, ...] = () if bare else (self._ndir,)
        if slip.ndim < 1 + len(axes) or (axes and slip.shape[-1] != self._ndir):
            raise MepcError(f"slip has the shape {slip.shape}, expected [.., n, {self._ndir}], a row an increment", -4)
        steps = slip.shape[: slip.ndim - len(axes)]
        lead, n = steps[:-1], steps[-1]
        pressure = reals("pressure", pressure, steps)
        if mu_factor is not None:
            mu_factor = reals("mu_factor", mu_factor, steps)
        end = self.virgin(*lead) if state is None else np.array(reals("state", state, (*lead, self._nstate)))
        traction = np.empty(steps + axes)
        dslip = np.empty(steps + axes + axes) if tangents else None
        dpressure = np.empty(steps + axes) if tangents else None
        energies = np.empty((*steps, 2)) if energy else None
        arrays = [address(array) for array in (slip, pressure, mu_factor, end, traction, dslip, dpressure, energies)]
        if not lead:
            status, statuses = LIBRARY.mepc_friction_history(self._law, n, *arrays), None
        else:
            statuses = np.empty(lead, np.int32)
            status = LIBRARY.mepc_friction_history_batch(
                self._law, statuses.size, n, *arrays, address(statuses), self._threads)
        _tell(checked(status, statuses), statuses)
        return History(traction, end, energies, dslip, dpressure)

    def _states(self, states: ArrayLike) -> tuple[np.ndarray, tuple[int, ...]]:
        states = reals("states", states)
        if states.ndim == 0 or states.shape[-1] != self._nstate:
            raise MepcError(f"states has the shape {states.shape}, expected [.., {self._nstate}]", -4)
        return states, states.shape[:-1]

    def _directions(self, name: str, values: ArrayLike, lead: tuple[int, ...]) -> tuple[np.ndarray, tuple[int, ...]]:
        """Vectors of slip directions, and the axes that these have beyond those of the points."""
        values = reals(name, values)
        if self._ndir == 1 and values.shape == lead:
            return values, ()
        return _exact(name, values, (*lead, self._ndir)), (self._ndir,)


def _again(props: np.ndarray, ndir: int, nstate: int, threads: int) -> Law:
    return Law.from_props(props, ndir=ndir, nstate=nstate, threads=threads)


def _number(name: str, value: str | float, names: dict[str, float]) -> float:
    if not isinstance(value, str):
        return value
    if value not in names:
        raise MepcError(f"{name} = {value!r}: must be one of {', '.join(map(repr, names))}, or its number", -2)
    return names[value]


def _exact(name: str, values: ArrayLike, shape: tuple[int, ...]) -> np.ndarray:
    array = reals(name, values)
    if array.shape != shape:  # The library sees addresses only.
        raise MepcError(f"{name} has the shape {array.shape}, expected {shape}", -4)
    return array


def _outputs(
    out: Update | Interface | None, shapes: Iterable[tuple[int, ...]], wanted: Iterable[bool], lead: tuple[int, ...]
) -> tuple[list[Any], np.ndarray]:
    """Arrays to be written, new ones or those of `out` (None for those not wanted), and the statuses."""
    if out is None:
        arrays: list[Any] = [np.empty(shape) if want else None for shape, want in zip(shapes, wanted)]
        return arrays, np.empty(lead, np.int32)
    arrays = []
    array: Any
    for name, array, shape, want in zip(out._fields, out, shapes, wanted):
        if want:
            fits = isinstance(array, np.ndarray) and array.shape == shape and array.dtype == np.float64
            if not (fits and array.flags.c_contiguous and array.flags.writeable):
                raise MepcError(f"out.{name} is not a writable float64 array of the shape {shape} in C order", -4)
        arrays.append(array if want else None)
    statuses = out.statuses
    if statuses.shape != lead or statuses.dtype != np.int32 or not statuses.flags.c_contiguous:
        raise MepcError(f"out.statuses is not an int32 array of the shape {lead} in C order", -4)
    return arrays, statuses


def _tell(status: int, statuses: np.ndarray | None) -> None:
    if status > 0:
        full, points = (1, 1) if statuses is None else (int((statuses > 0).sum()), statuses.size)
        warnings.warn(_FULL.format(full, points), MepcWarning, stacklevel=3)
