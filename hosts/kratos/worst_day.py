#!/usr/bin/env python3
"""A host's worst day, in Kratos: rejected steps, threads, input that must be refused."""

import os
import subprocess
import sys

os.environ.setdefault("OMP_NUM_THREADS", "1")
import numpy as np  # noqa: E402

from box import AMPLITUDE, FRICTION, Box, history  # noqa: E402
from host import MOST_ITERATIONS, Model, NotConverged, umat_parameters  # noqa: E402

MESH, STEPS = (4, 2), 10
# The state variables that Kratos can print.
PRINTED = range(1, 51)
# What must be refused, and a word of the message.
REFUSED = {
    "too few state variables": ({"states": 10}, "NSTATV"),
    "too few properties": ({"parameters": umat_parameters("memory")[:1]}, "PROPS"),
    "a property out of range": ({"parameters": [-0.3, *umat_parameters("memory")[1:]]}, "mu"),
    "no layout": ({"parameters": umat_parameters("memory")[:20]}, "NTENS"),
}


def everything(model):
    """Displacements, states and forces, to be compared bit by bit."""
    parts = model.displacements(), [model.state(number) for number in PRINTED], model.forces()
    return np.concatenate([np.ravel(part) for part in parts])


def rejected_steps(options):
    """The end of a history with and without steps that did not converge on the way: the largest difference."""
    path, half = history(STEPS), 2 * STEPS + STEPS // 2
    ends = []
    for disturbed in (False, True):
        model = Model(Box("pressed", MESH), "memory", options.library)
        for displacement in path[:half]:
            model.move(displacement)
        if disturbed:
            model.strategy.SetMaxIterationNumber(1)
            for displacement in (-8 * AMPLITUDE, 8 * AMPLITUDE, 0.3 * AMPLITUDE):
                try:
                    model.move(displacement)
                except NotConverged:
                    continue
                raise AssertionError("a step that had to be rejected was accepted")
            model.strategy.SetMaxIterationNumber(MOST_ITERATIONS)
        for displacement in path[half:]:
            model.move(displacement)
        ends.append(everything(model))
    return np.abs(ends[0] - ends[1]).max()


def child(options, what, threads=1):
    """This file in a process of its own."""
    environment = os.environ | {"OMP_NUM_THREADS": str(threads)}
    return subprocess.run(
        [sys.executable, __file__, str(options.library), what], env=environment, capture_output=True, text=True)


def run(options, results):
    """All of it."""
    results.check("rejected steps: difference at the end", rejected_steps(options), 0.0)

    ends = [child(options, "threads", threads) for threads in (1, 2)]
    numbers = [np.array(end.stdout.split("forces")[-1].split(), float) for end in ends]
    force, normal = numbers[0]
    # Threads add up the matrix in any order, so rounding differs.
    difference = np.abs(numbers[1] - numbers[0]).max() / (FRICTION * normal)
    results.check("2 threads against 1: forces, over mu N", difference, 1e-9)

    for what, (_, word) in REFUSED.items():
        done = child(options, what)
        said = [line for line in done.stderr.splitlines() if line.startswith("mepc UMAT:") and word in line]
        if said:
            print(f"    {said[0]}")
        refused = done.returncode == 1 and said
        results.check(f"{what}: exit code 1 with our message (0 is yes)", float(not refused), 0.0)
    results.skip(
        "restart from a saved state",
        "this release cannot save a model with these elements (its serializer does not know their geometry), and "
        "prints state variables interpolated; OpenGeoSys runs this test")


def main():
    library, what = sys.argv[1:]
    changed = REFUSED[what][0] if what in REFUSED else {}
    model = Model(Box("pressed", MESH), "memory", library, **changed)
    for displacement in history(STEPS)[: 3 * STEPS + 2]:
        model.move(displacement)
    print("forces", *map(repr, model.forces()))


if __name__ == "__main__":
    main()
