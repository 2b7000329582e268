# SPDX-License-Identifier: MIT OR Apache-2.0
"""Checks of the distributed host: any number of ranks, scikit-fem, restart, killed ranks, refused points, sweeps.

    python hosts/dolfinx/check.py           # up to three ranks, needs also build/hosts-venv
    python hosts/dolfinx/check.py --small   # two ranks, flat and slider, about a minute

Exit code 1 if one fails. `--trouble NAME ARGUMENTS` is what it starts under mpirun: run.py with something going wrong."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np  # noqa: E402

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BUILD = ROOT / "build/hosts/dolfinx/check"
LIMIT = 1200  # seconds for one run; ranks that wait for each other would never end
SAME = 1e-9  # of the largest value: the same run on other ranks
failures = []


# --- what goes wrong, under mpirun ----------------------------------------------------------------------------------------


def trouble(kind, place):
    """A hook for run.py: in the step `place` (1-based) the last rank fails while it evaluates its pairs."""
    from mpi4py import MPI

    def hook(solver):
        contact, history = solver.contact, solver.model.history
        evaluate, calls = contact.evaluate, [0]
        if kind == "halved":  # what a cut must give
            solver.model.history = np.insert(history, place - 1, history[place - 2:place].mean())
            return
        # The last rank that has pairs.
        world = MPI.COMM_WORLD
        owner = world.allreduce(world.rank if len(contact.offset) else -1, MPI.MAX)

        def failing(opening, state):
            here = world.rank == owner and solver._load[0] == history[place - 1]
            if here and kind == "refused" and solver._before.load[0] == history[place - 2]:  # the whole step only
                opening = opening.copy()
                opening[-1] = np.nan
            if here and kind in ("killed", "exception"):
                calls[0] += 1
                if calls[0] == 3:  # in the middle of the iterations
                    if kind == "killed":
                        os.kill(os.getpid(), signal.SIGKILL)
                    raise RuntimeError("an exception on one rank")
            return evaluate(opening, state)

        contact.evaluate = failing

    return hook


# --- the checks -----------------------------------------------------------------------------------------------------------


def expect(what, value, bound):
    """The value must not exceed the bound (a NaN fails)."""
    good = bool(value <= bound)
    print(f"{'ok    ' if good else 'FAILED'} {what}: {value:.3g}, at most {bound:.3g}", flush=True)
    if not good:
        failures.append(what)


def expect_words(what, text, *words):
    for line in text.splitlines():
        if any(word in line for word in words):
            print(f"       {line}")
    expect(f"{what}, words missing", sum(word not in text for word in words), 0)


def mpirun(ranks, *arguments, script="run.py", fails=False):
    """Output of a run; it must end in time, and well unless it is to fail."""
    command = [Path(sys.executable).parent / "mpirun", "-n", ranks, sys.executable, HERE / script, *arguments]
    began = time.perf_counter()
    # MPICH waits by spinning; with more ranks than idle cores it must let the others work.
    patient = {**os.environ, "MPIR_CVAR_ENABLE_HEAVY_YIELD": "1"}
    done = subprocess.run([str(part) for part in command], env=patient, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=LIMIT)
    print(f"       {ranks} ranks, {time.perf_counter() - began:.1f} s: {' '.join(map(str, arguments))}")
    if (done.returncode != 0) != fails:
        print(done.stdout)
        raise SystemExit(f"exit code {done.returncode}")
    return done.stdout


def table(name):
    from files import read_table

    return read_table(BUILD / f"{name}.csv")


def largest_difference(one, other, columns=None):
    """Over the largest value of all forces, for dissipation over its own."""
    worst = 0.0
    for name in columns or [name for name in one if name == "force" or name.startswith(("normal", "shear"))]:
        scale = np.abs(one["force" if name != "dissipated" else name]).max()
        worst = max(worst, np.abs(one[name] - other[name]).max() / scale)
    return worst


def expect_same(what, one, other):
    expect(f"{what}: lengths of the tables", abs(len(one["force"]) - len(other["force"])), 0)
    if len(one["force"]) == len(other["force"]):
        expect(f"{what}: forces", largest_difference(one, other), SAME)
        expect(f"{what}: dissipation", largest_difference(one, other, ["dissipated"]), SAME)
        expect(f"{what}: iterations", np.abs(one["iterations"] - other["iterations"]).max(), 0)


def ranks_and_reference(model, arguments, limit, ranks, python):
    """The same on all numbers of ranks, and what scikit-fem gives."""
    for number in ranks:
        text = mpirun(number, model, *arguments, "--output", BUILD, "--name", f"{model}-{number}")
        print("       " + next(line for line in text.splitlines() if "straddl" in line or "ranks" in line))
    tables = {number: table(f"{model}-{number}") for number in ranks}
    first = tables[ranks[0]]
    for number in ranks[1:]:
        expect_same(f"{model}: {number} ranks and {ranks[0]}", first, tables[number])
    file = BUILD / f"{model}-scikit-fem.csv"
    subprocess.run([python, ROOT / "hosts/scikit_fem/loops_for_dolfinx.py", model, file, *arguments], check=True)
    reference = table(file.stem)
    expect(f"{model}: force against scikit-fem, over F_s", np.abs(first["force"] - reference["force"]).max() / limit, 1e-6)
    expect(f"{model}: dissipation against scikit-fem, over the largest", np.abs(
        first["dissipated"] - reference["dissipated"]).max() / reference["dissipated"].max(), 1e-6)
    return first


def restart(model, arguments, whole, ranks):
    """Stopped and resumed on other numbers of ranks."""
    steps = len(whole["force"]) - 1
    name = f"{model}-restart"
    (BUILD / f"{name}.h5").unlink(missing_ok=True)
    common = [model, *arguments, "--output", BUILD, "--name", name, "--checkpoint-every", 4, "--resume"]
    for part, number in enumerate(ranks, 1):
        stop = [] if part == len(ranks) else ["--stop", part * steps // len(ranks)]
        mpirun(number, *common, *stop)
    expect_same(f"{model}: restart {' -> '.join(map(str, ranks))} ranks", whole, table(name))
    text = mpirun(1, model, *arguments, "mu=0.2", *common[1 + len(arguments):], fails=True)
    expect_words("checkpoint of another model", text, f"{name}.h5", "model is", '"mu": 0.2')


def killed(model, arguments, whole, ranks):
    """A rank is killed, or raises an exception, in the middle of a step: the run ends, and is resumed elsewhere."""
    for kind, words in (("killed", ("BAD TERMINATION", "EXIT CODE: 9")), ("exception", ("RuntimeError: an exception on one rank",))):
        name = f"{model}-{kind}"
        (BUILD / f"{name}.h5").unlink(missing_ok=True)
        common = [model, *arguments, "--output", BUILD, "--name", name, "--checkpoint-every", 4]
        text = mpirun(ranks[0], "--trouble", kind, 11, *common, script="check.py", fails=True)
        expect_words(kind, text, *words)
        text = mpirun(ranks[1], *common, "--resume")
        expect_words(f"{kind}, resumed", text, "goes on after step 8 of")
        expect_same(f"{model}: {kind} on {ranks[0]} ranks, resumed on {ranks[1]}", whole, table(name))


def refused(model, arguments, ranks):
    """The library refuses a point on one rank: the step is cut on all, and ends where its halves do."""
    common = [model, *arguments, "--output", BUILD]
    text = mpirun(ranks, "--trouble", "refused", 9, *common, "--name", f"{model}-refused", script="check.py")
    expect_words("refused", text, "step 9: line search basic", f"rank {ranks - 1}", "opening", "cut in two")
    mpirun(ranks, "--trouble", "halved", 9, *common, "--name", f"{model}-halved", script="check.py")
    cut, halved = table(f"{model}-refused"), table(f"{model}-halved")
    expect("refused: cuts", abs(cut["cuts"].sum() - 1), 0)
    middle = len(halved["force"]) - len(cut["force"])  # one row more
    expect("refused: rows", abs(middle - 1), 0)
    ends = {name: np.delete(column, 8) for name, column in halved.items()}
    expect("refused: forces against the two halves", largest_difference(cut, ends), SAME)
    expect("refused: dissipation against the two halves", abs(
        cut["dissipated"].sum() / halved["dissipated"].sum() - 1), SAME)


def sweep():
    """Three cases over two groups, one result deleted, resumed with one group of two."""
    folder = BUILD / "sweep"
    folder.mkdir(parents=True, exist_ok=True)
    for file in folder.iterdir():
        file.unlink()
    cases = folder / "cases.csv"
    cases.write_text("name,preload,mu\none,300,\ntwo,,0.2\nthree,500,0.1\n")
    common = ["--list", cases, "--output", folder, "--checkpoint-every", 4, "mesh=smallest", "quarter=2"]
    mpirun(2, "--group", 1, *common, script="sweep.py")
    first = {name: table(f"sweep/{name}") for name in ("one", "two", "three")}
    (folder / "two.json").unlink()
    text = mpirun(2, "--group", 2, *common, script="sweep.py")
    expect("sweep resumed: cases done again", abs(sum(f"{name}, step 1" in text for name in first) - 1), 0)
    expect_words("sweep resumed", text, "two, step 1", "3 cases, 0 without equilibrium")
    for name in first:
        expect_same(f"sweep, case {name}: one rank and two", first[name], table(f"sweep/{name}"))


def multigrid(model, arguments, whole, limit):
    """The iterative solver gives the same loop."""
    mpirun(2, model, *arguments, "--linear", "multigrid", "--output", BUILD, "--name", f"{model}-multigrid")
    other = table(f"{model}-multigrid")
    expect(f"{model}: multigrid, force over F_s", np.abs(other["force"] - whole["force"]).max() / limit, 1e-8)
    count = other["linear_iterations"].sum() / other["iterations"].sum()
    print(f"       {count:.1f} iterations of GMRES for each of Newton")


def main():
    BUILD.mkdir(parents=True, exist_ok=True)
    small = "--small" in sys.argv
    ranks = (1, 2) if small else (1, 2, 3)
    mu_n = 0.43 * 1000
    arguments = ["along=2", "quarter=4" if small else "quarter=6"]
    whole = ranks_and_reference("flat_slider", arguments, mu_n, ranks, sys.executable)
    restart("flat_slider", arguments, whole, (2, 1) if small else (2, 1, 3))
    killed("flat_slider", arguments, whole, (2, 1) if small else (2, 3))
    refused("flat_slider", arguments, 2)
    if not small:
        multigrid("flat_slider", arguments, whole, mu_n)
        sweep()
        joint = ["mesh=coarse"]
        whole = ranks_and_reference("lap_joint", joint, 270.0, ranks, ROOT / "build/hosts-venv/bin/python")
        restart("lap_joint", joint, whole, (2, 1, 3))
    print(f"{len(failures)} failed" + "".join(f"\n  {what}" for what in failures))
    return 1 if failures else 0


if __name__ == "__main__":
    if sys.argv[1:2] == ["--trouble"]:
        from host import abort_on_error
        from run import main as run

        _, _, kind, place, *rest = sys.argv
        sys.argv[1:] = rest
        abort_on_error(lambda: run(trouble(kind, int(place))))
    sys.exit(main())
