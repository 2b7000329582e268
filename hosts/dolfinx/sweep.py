# SPDX-License-Identifier: MIT OR Apache-2.0
"""Many cases of the lap joint over groups of ranks: Table 1 of the paper, or a list of one's own.

    mpirun -n 2 python hosts/dolfinx/sweep.py --group 1 mesh=smallest quarter=4
    mpirun -n 8 python hosts/dolfinx/sweep.py --group 4 --list cases.csv --checkpoint-every 10

A list is a CSV file: the column `name`, and columns named as the arguments of lap_joint in models.py; an empty field is
the default. Each case writes NAME.csv (the loop) and NAME.json (what it was, and its figures) when it is done, and
sweep.csv collects them. Started again, the sweep leaves out what is done and goes on from checkpoints.
Exit code 1 if a case has no equilibrium; the others are not stopped by that."""

import csv
import json
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

from pathlib import Path  # noqa: E402

import numpy as np  # noqa: E402
from mpi4py import MPI  # noqa: E402

from files import mesh_digest, replace_file  # noqa: E402
from host import NoEquilibrium, Solver, abort_on_error  # noqa: E402
from loop import follow  # noqa: E402
from models import lap_joint, shared, table_1  # noqa: E402
from run import OUTPUT, arguments, parser  # noqa: E402
from structure import Structure  # noqa: E402


def listed(file, common):
    """Cases of a list: arguments by name."""
    cases = {}
    with open(file, newline="") as text:
        for row in csv.DictReader(text):
            name = (row.pop("name", None) or "").strip()
            if not name or name in cases:
                raise SystemExit(f"{file}: every case needs a name of its own, found {name!r}")
            cases[name] = {**common, **arguments(lap_joint, [f"{key}={value}" for key, value in row.items() if value])}
    return cases


def figures(rows):
    """Of the closed cycle that ends the history."""
    displacement, force = (np.array([row[name] for row in rows]) for name in ("displacement", "force"))
    cycle = slice(int(np.argmax(displacement)), None)
    dissipated = np.array([row["dissipated"] for row in rows])
    return {
        "largest_force": float(np.abs(force[cycle]).max()),
        "loop_area": float(np.trapezoid(force[cycle], displacement[cycle])),
        "dissipated": float(dissipated[cycle][1:].sum()),
        "iterations": int(sum(row["iterations"] for row in rows)),
    }


class Group:
    """The ranks that work on one case after the other."""

    def __init__(self, comm, given):
        self.comm, self.given = comm, given
        self.structure, self.digest = None, None

    def solver(self, model, say):
        """One structure serves all cases of a mesh."""
        digest = self.comm.bcast(mesh_digest(model) if self.comm.rank == 0 else None)
        if digest != self.digest:
            self.structure, self.digest = Structure(self.comm, model), digest
        return Solver(self.structure, model, self.given.linear, say)

    def run(self, name, keywords):
        """True when the case is done, also when it was before."""
        model = shared(self.comm, lambda: lap_joint(**keywords))
        file = self.given.output / f"{name}.json"
        if self.comm.bcast(file.is_file() and json.loads(file.read_text())["model"] == model.key):
            return True
        solver = self.solver(model, lambda text: print(text, flush=True))
        try:
            rows = follow(solver, self.given.output, self.given.checkpoint_every, True, name=name)
        except NoEquilibrium as error:
            solver.say(f"{name}: {error}")
            return False
        if self.comm.rank == 0:
            text = json.dumps({"model": model.key, **figures(rows)}, indent=1) + "\n"
            replace_file(file, lambda part: part.write_text(text))
            (self.given.output / f"{name}.h5").unlink(missing_ok=True)
        return True


def collect(folder, names):
    """sweep.csv from what the cases left."""
    found = [(name, json.loads(file.read_text())) for name in names if (file := folder / f"{name}.json").is_file()]
    if not found:
        return
    with open(folder / "sweep.csv", "w", newline="") as out:
        rows = [{"name": name, **{key: value for key, value in case["model"].items() if key != "model"},
                 **{key: value for key, value in case.items() if key != "model"}} for name, case in found]
        writer = csv.DictWriter(out, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def main():
    options = parser(__doc__)
    options.add_argument("--group", type=int, default=1, help="ranks for one case")
    options.add_argument("--list", type=Path, help="CSV file of cases, default Table 1 of the paper")
    options.add_argument("set", nargs="*", metavar="NAME=VALUE", help="arguments of all cases")
    given = options.parse_args()
    world = MPI.COMM_WORLD
    if given.group < 1 or world.size % given.group:
        raise SystemExit(f"--group {given.group}: a divisor of the number of ranks was expected, {world.size}")
    common = arguments(lap_joint, given.set)
    cases = listed(given.list, common) if given.list else table_1(**common)
    if given.output == OUTPUT:
        given.output = OUTPUT / "sweep"
    given.output.mkdir(parents=True, exist_ok=True)

    # Every group takes each (number of groups)th case: known beforehand, nobody has to ask.
    color = world.rank // given.group
    group = Group(world.Split(color, world.rank), given)
    mine = list(cases.items())[color::world.size // given.group]
    failed = [name for name, keywords in mine if not group.run(name, keywords)]
    failed = sorted({name for names in world.allgather(failed) for name in names})
    if world.rank == 0:
        collect(given.output, cases)
        print(f"{len(cases)} cases, {len(failed)} without equilibrium" + "".join(f"\n  {name}" for name in failed),
              flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    abort_on_error(main)
