# SPDX-License-Identifier: MIT OR Apache-2.0
"""Every call of the library that this host makes: the interface form for many points at once, through ctypes."""

import ctypes
import os
from pathlib import Path

import numpy as np

LIBRARY = Path(__file__).resolve().parents[2] / "target/release/libmepc.so"
ABI_VERSION = 1

_reals = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
_integers = np.ctypeslib.ndpointer(np.int32, flags="C_CONTIGUOUS")


class LawError(ValueError):
    """The library refused properties; the text is mepc_last_error."""


class Refused(LawError):
    """The library refused a point of a batch: its number in the batch and the cause in words."""

    def __init__(self, point, cause):
        super().__init__(cause)
        self.point = point


def _load(path):
    library = ctypes.CDLL(str(path))
    if library.mepc_abi_version() != ABI_VERSION:
        raise ImportError(f"{path}: interface version {library.mepc_abi_version()}, expected {ABI_VERSION}")
    int32, pointer = ctypes.c_int32, ctypes.c_void_p
    library.mepc_last_error.restype = library.mepc_state_name.restype = ctypes.c_char_p
    library.mepc_state_name.argtypes = [pointer, int32]
    library.mepc_state_size.argtypes = [_reals, int32, int32]
    library.mepc_law_new.argtypes = [_reals, int32, int32, int32, ctypes.POINTER(pointer)]
    library.mepc_law_free.argtypes = [pointer]
    library.mepc_law_free.restype = None
    library.mepc_interface_batch.argtypes = [pointer, ctypes.c_int64] + [_reals] * 6 + [_integers, int32]
    return library


def properties(mu, gcr, chi, method, kn):
    """PROPS of the library's property table. method: memory or penalty. The paper's rule for changing pressure."""
    proportional, fraction = 0, 0.005
    return [mu, gcr, chi, {"memory": 0, "penalty": 1}[method], proportional, fraction, kn]


class Law:
    """A law of two tangential directions."""

    def __init__(self, props):
        self._library = _load(os.environ.get("MEPC_LIBRARY", LIBRARY))
        self._law = ctypes.c_void_p()
        props = np.array(props, float)
        self.nstate = self._checked(self._library.mepc_state_size(props, props.size, 2))
        self._checked(self._library.mepc_law_new(props, props.size, 2, self.nstate, ctypes.byref(self._law)))
        self.names = [self._library.mepc_state_name(self._law, index).decode() for index in range(self.nstate)]

    def __del__(self):
        if getattr(self, "_law", None):
            self._library.mepc_law_free(self._law)

    def _error(self):
        return self._library.mepc_last_error().decode()

    def _checked(self, status):
        if status < 0:
            raise LawError(self._error())
        return status

    def interface(self, opening, state):
        """Traction [point, 3], tangent [point, 3, 3], new state and energy (stored, dissipated now) of each point.

        opening[point]: total opening, normal first; `state` is the one before the step and is left as it is. One
        thread: the ranks are the parallelism. Raises Refused."""
        points = len(opening)
        opening, state = np.ascontiguousarray(opening, float), np.ascontiguousarray(state, float)
        for name, array, width in (("opening", opening, 3), ("state", state, self.nstate)):
            if array.shape != (points, width):  # the library sees pointers only
                raise ValueError(f"{name} has the shape {array.shape}, expected {(points, width)}")
        new, traction = np.empty_like(state), np.empty_like(opening)
        tangent, energy, status = np.empty((points, 3, 3)), np.empty((points, 2)), np.zeros(points, np.int32)
        worst = self._library.mepc_interface_batch(
            self._law, points, opening, state, new, traction, tangent, energy, status, 1)
        if worst < 0:  # the words are about the first point with that status
            raise Refused(int(np.argmax(status == worst)), self._error())
        return traction, tangent, new, energy
