# SPDX-License-Identifier: MIT OR Apache-2.0
"""python -m mepc: paths for decks, compilers and scripts."""

import argparse

from . import __version__, include, library
from ._library import find_tool


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m mepc", description="Paths of the mepc package.")
    parser.add_argument("--version", action="version", version=f"mepc {__version__}")
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("--library", action="store_true", help="the shared library, for a deck")
    which.add_argument("--include", action="store_true", help="the directory of mepc.h and mepc.f90, for a compiler")
    which.add_argument("--tool", action="store_true", help="the program mepc")
    given = parser.parse_args()
    print(library if given.library else include if given.include else find_tool())


if __name__ == "__main__":
    main()
