# SPDX-License-Identifier: MIT OR Apache-2.0
"""The improved four-parameter Iwan model of a joint: its forces, its parameters from a measured loop, and the contact
law from measured loops."""

from __future__ import annotations

import json
import subprocess
import tempfile
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ._library import LIBRARY, MepcError, MepcWarning, address, checked, find_tool, reals

if TYPE_CHECKING:  # NumPy 1.19 has no such module
    from numpy.typing import ArrayLike

_METHODS = {"least_squares": 0, "paper": 1}
_NOT_DESCRIBED = 2
_FLAGGED = 3  # exit code of the tool: done, but the data do not determine the parameters


@dataclass(frozen=True)
class Iwan:
    """The joint model: T = F_s [1 - (1 - x / X_s)^chi] + k_alpha x at first loading, Masing's branches after that.

    Attributes:
        F_s: force at gross slip, > 0.
        X_s: displacement at gross slip, > 0.
        k_alpha: residual stiffness, force per length, >= 0.
        kappa: exponent; chi = 5/2 + kappa >= 1.
    """

    F_s: float
    X_s: float
    k_alpha: float
    kappa: float

    @property
    def chi(self) -> float:
        """Exponent of the backbone, 5/2 + kappa."""
        return 2.5 + self.kappa

    def force(self, displacement: ArrayLike, branch: ArrayLike, amplitude: float) -> np.ndarray:
        """Forces of the steady loop of an amplitude (> 0).

        Args:
            displacement: [n], length. Beyond the amplitude the curve of first loading goes on.
            branch: [n] or one number: +1 while the displacement grows, -1 while it falls.
            amplitude: of the loop, length.
        """
        displacement = reals("displacement", displacement)
        branch = np.asarray(branch)
        # Checked by the library; what does not fit a byte must not turn into what does.
        signs = np.where(np.abs(branch) == 1, branch, 0).astype(np.int8)
        signs = np.ascontiguousarray(np.broadcast_to(signs, displacement.shape))
        force = np.empty_like(displacement)
        params = np.array([self.F_s, self.X_s, self.k_alpha, self.kappa], np.float64)
        checked(LIBRARY.mepc_iwan_force(
            address(params), amplitude, displacement.size, address(displacement), address(signs), address(force)))
        return force

    def loop(self, amplitude: float, points: int = 200) -> tuple[np.ndarray, np.ndarray]:
        """Displacement and force of a steady cycle, [2 points] each: up from -amplitude, and back."""
        up = np.linspace(-amplitude, amplitude, points)
        displacement = np.concatenate([up, up[::-1]])
        return displacement, self.force(displacement, np.repeat([1, -1], points), amplitude)


@dataclass(frozen=True)
class Identification:
    """What `identify` found.

    Attributes:
        joint: the parameters.
        standard_errors: [4] of F_s, X_s, k_alpha, kappa.
        misfit: root mean square of measured minus fitted force, over the largest force.
        described: False where the model does not describe the loop (a `MepcWarning` says so, too): the parameters are
            the best there are, and must not be relied upon.
    """

    joint: Iwan
    standard_errors: np.ndarray
    misfit: float
    described: bool


def identify(displacement: ArrayLike, force: ArrayLike, method: str = "least_squares") -> Identification:
    """The four parameters of the joint model from a measured loop.

    Args:
        displacement, force: [n] in the order of time, one or more cycles of one amplitude about any centre; reversals
            are found, first loading is left out, noise is allowed.
        method: "least_squares" over all branches at once, or "paper", the paper's own procedure (rougher).

    Raises:
        MepcError: the data do not give the parameters (no gross slip, another kind of loop, ..); the text says why.
    """
    displacement, force = reals("displacement", displacement), reals("force", force)
    if displacement.ndim != 1 or displacement.shape != force.shape:
        shapes = f"{displacement.shape} and {force.shape}"
        raise MepcError(f"displacement and force have the shapes {shapes}, expected [n] both", -4)
    if method not in _METHODS:
        raise MepcError(f"method = {method!r}: must be one of {', '.join(map(repr, _METHODS))}", -4)
    params, errors, misfit = np.empty(4), np.empty(4), np.empty(1)
    status = checked(LIBRARY.mepc_iwan_identify(
        displacement.size, address(displacement), address(force), _METHODS[method], address(params), address(errors),
        address(misfit)))
    if status == _NOT_DESCRIBED:
        # Why, this one time without an error.
        warnings.warn(LIBRARY.mepc_last_error().decode(), MepcWarning, stacklevel=2)
    return Identification(Iwan(*params.tolist()), errors, float(misfit[0]), status != _NOT_DESCRIBED)


def calibrate(
    loops: Sequence[tuple[ArrayLike, ArrayLike]],
    preloads: Sequence[float],
    area: float,
    *options: str,
) -> dict[str, Any]:
    """Properties of the contact law from measured loops, by `mepc calibrate`.

    Args:
        loops: a pair of displacement and force for each preload, as in `identify`; mm and N.
        preloads: bolt preload of each loop, N.
        area: of the contact, mm2.
        options: further options of the tool, for example "--chi", "2".

    Returns:
        The tool's JSON object: mu, gcr, chi, K_e, k_alpha, standard_errors, reliable, warnings, props, ..

    Raises:
        MepcError: the tool refused; the text is its own.
    """
    if len(loops) != len(preloads):
        raise MepcError(f"{len(loops)} loops and {len(preloads)} preloads, one is needed for each", -4)
    with tempfile.TemporaryDirectory(prefix="mepc-") as folder:
        command = [str(find_tool()), "calibrate", "--json", "--area", repr(float(area)), *options]
        for number, (loop, preload) in enumerate(zip(loops, preloads), 1):
            columns = np.column_stack([reals("displacement", loop[0]), reals("force", loop[1])])
            file = Path(folder) / f"loop-{number}.csv"
            np.savetxt(file, columns, fmt="%.17g", delimiter=",", header="displacement,force", comments="")
            command += [f"--preload={float(preload)!r}", str(file)]
        run = subprocess.run(command, capture_output=True, text=True)
        said = run.stderr.replace(f"{folder}/", "").strip()
    if run.returncode not in (0, _FLAGGED):
        raise MepcError(said, -4)
    result: dict[str, Any] = json.loads(run.stdout.replace(f"{folder}/", ""))
    if run.returncode == _FLAGGED:
        warnings.warn(said, MepcWarning, stacklevel=2)
    return result
