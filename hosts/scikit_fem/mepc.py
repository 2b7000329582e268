# SPDX-License-Identifier: MIT OR Apache-2.0
"""The contact law for Python: the interface form of libmepc.so for many points at once, through ctypes."""

import ctypes
import os
import warnings
from pathlib import Path

import numpy as np

LIBRARY = Path(__file__).resolve().parents[2] / "target/release/libmepc.so"
ABI_VERSION = 1

_reals = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")


class MepcError(ValueError):
    """A call the library refused; the text is mepc_last_error."""


def _load(path):
    library = ctypes.CDLL(str(path))
    if library.mepc_abi_version() != ABI_VERSION:
        raise ImportError(f"{path}: interface version {library.mepc_abi_version()}, expected {ABI_VERSION}")
    int32, pointer = ctypes.c_int32, ctypes.c_void_p
    library.mepc_last_error.restype = ctypes.c_char_p
    library.mepc_state_size.argtypes = [_reals, int32, int32]
    library.mepc_law_new.argtypes = [_reals, int32, int32, int32, ctypes.POINTER(pointer)]
    library.mepc_law_free.argtypes = [pointer]
    library.mepc_law_free.restype = None
    library.mepc_interface_batch.argtypes = [pointer, ctypes.c_int64, _reals, pointer] + [_reals] * 5 + [pointer, int32]
    return library


class Law:
    """Properties checked once, see the README's property table. nstate: numbers per state, default the library's."""

    def __init__(self, props, ndir=2, nstate=None, threads=1, library=None):
        self._library = _load(library or os.environ.get("MEPC_LIBRARY", LIBRARY))
        self._law = ctypes.c_void_p()
        self.ndir, self.threads = ndir, threads
        props = np.array(props, float)
        if nstate is None:
            nstate = self._checked(self._library.mepc_state_size(props, props.size, ndir))
        self.nstate = nstate
        self._checked(self._library.mepc_law_new(props, props.size, ndir, nstate, ctypes.byref(self._law)))

    def __del__(self):
        if getattr(self, "_law", None):
            self._library.mepc_law_free(self._law)

    def _checked(self, status):
        if status < 0:  # the text belongs to this thread's last error: read it before the next call
            raise MepcError(self._library.mepc_last_error().decode())
        return status

    def virgin(self, points):
        return np.zeros((points, self.nstate))

    def interface(self, opening, state):
        """Traction, tangent, new state and energy (stored, dissipated now) of each point; `state` is left as it is.

        opening[point]: total opening, normal first; the columns of traction and tangent are in the same order."""
        points, size = len(opening), 1 + self.ndir
        opening, state = np.ascontiguousarray(opening, float), np.ascontiguousarray(state, float)
        for name, array, shape in (("opening", opening, (points, size)), ("state", state, (points, self.nstate))):
            if array.shape != shape:  # the library sees pointers only
                raise MepcError(f"{name} has the shape {array.shape}, expected {shape}")
        new, traction = np.empty_like(state), np.empty_like(opening)
        tangent, energy = np.empty((points, size, size)), np.empty((points, 2))
        if self._checked(self._library.mepc_interface_batch(
                self._law, points, opening, None, state, new, traction, tangent, energy, None, self.threads)) > 0:
            warnings.warn("a state array is full: the least important reversal was dropped", stacklevel=2)
        return traction, tangent, new, energy
