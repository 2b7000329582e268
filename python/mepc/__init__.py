# SPDX-License-Identifier: MIT OR Apache-2.0
"""Friction with memory for finite-element contact: the library libmepc from Python, NumPy in, NumPy out.

    import numpy as np
    import mepc

    law = mepc.Law(mu=0.3, gcr=0.002, reference_pressure=100, ndir=1)  # mm, N, MPa
    slip = 0.003 * np.sin(np.linspace(0, 4 * np.pi, 400))
    done = law.history(np.diff(slip, prepend=0), 100.0)
    print(done.traction, done.energy[:, 1].sum())

`mepc.library` is the path of the shared library, for decks; `mepc.include` the directory of mepc.h and mepc.f90, for
compilers. `python -m mepc --library` prints them.
"""

from ._library import LIBRARY as _LIBRARY
from ._library import LIBRARY_PATH as _LIBRARY_PATH
from ._library import MepcError, MepcWarning
from ._library import find_include as _find_include
from .iwan import Identification, Iwan, calibrate, identify
from .law import PROPERTIES, History, Interface, Law, Update

#: Version of the library.
__version__: str = _LIBRARY.mepc_version().decode()
#: Path of the shared library.
library: str = str(_LIBRARY_PATH)
#: Directory of mepc.h and mepc.f90.
include: str = str(_find_include())

__all__ = [
    "PROPERTIES", "History", "Identification", "Interface", "Iwan", "Law", "MepcError", "MepcWarning", "Update",
    "__version__", "calibrate", "identify", "include", "library",
]
