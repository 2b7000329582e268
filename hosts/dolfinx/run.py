# SPDX-License-Identifier: MIT OR Apache-2.0
"""One loop of a model on any number of ranks.

    mpirun -n 2 python hosts/dolfinx/run.py flat_slider along=4 --checkpoint-every 10 --fields-every 10
    mpirun -n 3 python hosts/dolfinx/run.py flat_slider along=4 --checkpoint-every 10 --resume

NAME=VALUE are the arguments of the model's function in models.py. PETSc takes more options from PETSC_OPTIONS."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before anything loads it: the ranks are the parallelism
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse  # noqa: E402
import ast  # noqa: E402
import inspect  # noqa: E402
from pathlib import Path  # noqa: E402

from mpi4py import MPI  # noqa: E402

from host import Solver, abort_on_error  # noqa: E402
from loop import follow  # noqa: E402
from models import MODELS, ROOT, shared  # noqa: E402
from structure import Structure  # noqa: E402

OUTPUT = ROOT / "build/hosts/dolfinx"


def arguments(make, given):
    """NAME=VALUE to keyword arguments of a model."""
    known = inspect.signature(make).parameters
    found = {}
    for text in given:
        name, equals, value = text.partition("=")
        if not equals or name not in known:
            raise SystemExit(f"{text!r}: NAME=VALUE was expected, with a name among {', '.join(known)}")
        try:
            found[name] = ast.literal_eval(value)
        except (ValueError, SyntaxError):
            found[name] = value
        if not isinstance(found[name], (str, int, float)):
            raise SystemExit(f"{text!r}: a number or a word was expected")
    return found


def parser(description):
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--linear", choices=["direct", "multigrid"], default="direct", help="MUMPS, or GMRES with GAMG")
    parser.add_argument("--checkpoint-every", type=int, default=0, metavar="N", help="steps between checkpoints")
    parser.add_argument("--resume", action="store_true", help="go on from checkpoints that are there")
    parser.add_argument("--output", type=Path, default=OUTPUT, help="folder, default build/hosts/dolfinx")
    return parser


def main(hook=lambda solver: None):
    """hook: called with the solver before the loop (check.py)."""
    options = parser(__doc__)
    options.add_argument("model", choices=MODELS)
    options.add_argument("set", nargs="*", metavar="NAME=VALUE")
    options.add_argument("--fields-every", type=int, default=0, metavar="N", help="steps between XDMF fields")
    options.add_argument("--stop", type=int, metavar="N", help="end after so many steps")
    options.add_argument("--name", help="of the files, default the model's")
    given = options.parse_args()
    comm, make = MPI.COMM_WORLD, MODELS[given.model]
    keywords = arguments(make, given.set)
    model = shared(comm, lambda: make(**keywords))
    structure = Structure(comm, model)
    solver = Solver(structure, model, given.linear, say=lambda text: print(text, flush=True))
    solver.say(f"{structure.nodes} nodes, {structure.pairs} pairs, {structure.straddling} of them on two of {comm.size} "
               f"ranks")
    hook(solver)
    follow(solver, given.output, given.checkpoint_every, given.resume, given.fields_every, given.stop,
           given.name or given.model)


if __name__ == "__main__":
    abort_on_error(main)
