# SPDX-License-Identifier: MIT OR Apache-2.0
"""The shared library: where it is, its functions with their C types, its errors as exceptions."""

from __future__ import annotations

import ctypes
import os
import shutil
import sysconfig
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent
#: Version of the C interface that this package is written for.
ABI_VERSION = 2


class MepcError(ValueError):
    """A call that the library refused. The text is the library's: which argument, its value, what was expected.

    Attributes:
        status: the negative number of the C interface: -1 null pointer, -2 bad property, -3 bad state, -4 bad input,
            -5 internal.
        point: index of the point that was refused, in the order of the states; None where it is not about one of many.
    """

    def __init__(self, text: str, status: int, point: int | None = None) -> None:
        super().__init__(text)
        self.status = status
        self.point = point

    def __reduce__(self) -> Any:
        return type(self), (str(self), self.status, self.point)


class MepcWarning(UserWarning):
    """A result is valid, but not as good as it might be: the text says why."""


def find_library() -> Path:
    """The shared library: $MEPC_LIBRARY, or the one that this package brings along."""
    given = os.environ.get("MEPC_LIBRARY")
    path = Path(given).absolute() if given else HERE / "lib" / "libmepc.so"
    if not path.is_file():
        where = "MEPC_LIBRARY" if given else "this package has no library of its own"
        raise ImportError(f"{path}: no such file ({where}); `make wheel` builds a package with a library in it")
    return path


def find_include() -> Path:
    """The directory of mepc.h and mepc.f90."""
    return HERE / "include"


def find_tool() -> Path:
    """The program `mepc`: the one installed with this package, else the first on PATH."""
    own = Path(sysconfig.get_path("scripts")) / "mepc"
    found = str(own) if own.is_file() else shutil.which("mepc")
    if found is None:
        raise FileNotFoundError(f"the program mepc is neither {own} nor on PATH")
    return Path(found)


_int32, _int64, _double, _pointer = ctypes.c_int32, ctypes.c_int64, ctypes.c_double, ctypes.c_void_p

# Result and arguments of every function, as in mepc.h. Arrays are passed by address: their lengths are checked where
# the calls are made.
_FUNCTIONS: dict[str, tuple[Any, list[Any]]] = {
    "mepc_version": (ctypes.c_char_p, []),
    "mepc_last_error": (ctypes.c_char_p, []),
    "mepc_state_size": (_int32, [_pointer, _int32, _int32]),
    "mepc_law_new": (_int32, [_pointer, _int32, _int32, _int32, ctypes.POINTER(_pointer)]),
    "mepc_law_free": (None, [_pointer]),
    "mepc_state_name": (ctypes.c_char_p, [_pointer, _int32]),
    "mepc_friction_batch": (_int32, [_pointer, _int64] + 9 * [_pointer] + [_pointer, _int32]),
    "mepc_interface_batch": (_int32, [_pointer, _int64] + 7 * [_pointer] + [_pointer, _int32]),
    "mepc_friction_history": (_int32, [_pointer, _int64] + 8 * [_pointer]),
    "mepc_friction_history_batch": (_int32, [_pointer, _int64, _int64] + 8 * [_pointer] + [_pointer, _int32]),
    "mepc_iwan_force": (_int32, [_pointer, _double, _int64] + 3 * [_pointer]),
    "mepc_iwan_identify": (_int32, [_int64, _pointer, _pointer, _int32] + 3 * [_pointer]),
}


def load(path: Path) -> ctypes.CDLL:
    """The library with typed functions; refuses one of another interface version."""
    library = ctypes.CDLL(str(path))
    version = library.mepc_abi_version()
    if version != ABI_VERSION:
        raise ImportError(f"{path}: interface version {version}, this package needs {ABI_VERSION}")
    for name, (result, arguments) in _FUNCTIONS.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


LIBRARY_PATH = find_library()
LIBRARY = load(LIBRARY_PATH)


def checked(status: int, statuses: np.ndarray | None = None) -> int:
    """The status of a call; an exception with the library's words where it is negative. `statuses`: of its points."""
    if status < 0:  # The text is this thread's last error: read before the next call.
        text = LIBRARY.mepc_last_error().decode()
        raise MepcError(text, status, None if statuses is None else int(np.argmax(statuses.ravel() == status)))
    return status


def reals(name: str, values: Any, shape: tuple[int, ...] | None = None) -> np.ndarray:
    """An array of float64 in C order, itself if it is one already; with `shape`, a scalar or a row is repeated."""
    array = np.asarray(values, dtype=np.float64, order="C")
    if shape is not None and array.shape != shape:
        try:
            array = np.broadcast_to(array, shape).copy(order="C")
        except ValueError:
            raise MepcError(f"{name} has the shape {array.shape}, expected {shape}", -4) from None
    return array


def address(array: np.ndarray | None) -> int | None:
    """What C is given for an array, or for none."""
    return None if array is None else array.ctypes.data
