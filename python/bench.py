# SPDX-License-Identifier: MIT OR Apache-2.0
"""What a call from Python costs beside the call of the C function with arrays that are there already.

    python bench.py        medians over turns in which both are timed one after the other, in one process; times are the
                           processor's, so that other work on the machine counts little
"""

import statistics
import time

import numpy as np

from mepc import Law
from mepc._library import LIBRARY, address

TURNS = 11
N = 100_000


def ratio(name, python, c):
    """Both in turns; the median of each, and of the ratios."""
    python(), c()
    times = []
    for _ in range(TURNS):
        began = time.process_time()
        python()
        middle = time.process_time()
        c()
        times.append((middle - began, time.process_time() - middle))
    ours, theirs = (1e3 * statistics.median(column) for column in zip(*times))
    print(f"{name:44s} {ours:8.3f} ms {theirs:8.3f} ms {statistics.median(a / b for a, b in times):6.3f}")


def history(ndir):
    law = Law(mu=0.3, gcr=0.002, reference_pressure=100, ndir=ndir)
    phase = np.linspace(0, 200 * np.pi, N)
    slip = np.diff(0.0015 * np.column_stack([np.sin(phase), 0.7 * np.cos(1.3 * phase)])[:, :ndir], axis=0, prepend=0)
    slip, pressure = np.ascontiguousarray(slip), np.full(N, 100.0)
    state, traction, energy = law.virgin(), np.empty((N, ndir)), np.empty((N, 2))
    arguments = [address(array) for array in (slip, pressure, None, state, traction, None, None, energy)]

    def c():
        state[:] = 0
        LIBRARY.mepc_friction_history(law._law, N, *arguments)

    ratio(f"history of {N} increments, {ndir} direction(s)", lambda: law.history(slip, pressure), c)


def batch(ndir):
    law = Law(mu=0.3, gcr=0.002, reference_pressure=100, ndir=ndir)
    random = np.random.default_rng(1)
    states = law.virgin(N)
    for _ in range(5):
        states = law.update(states, 0.0008 * random.standard_normal((N, ndir)), 100.0).state
    slip, pressure = 0.0008 * random.standard_normal((N, ndir)), np.full(N, 100.0)
    out = law.update(states, slip, pressure)
    inputs = [address(array) for array in (slip, pressure, None, states)]
    outputs = [address(array) for array in (out.state, *(out[k] for k in (0, 2, 3, 4)), out.statuses)]

    def c():
        LIBRARY.mepc_friction_batch(law._law, N, *inputs, *outputs, 1)

    ratio(f"batch of {N} points, {ndir} direction(s), out=", lambda: law.update(states, slip, pressure, out=out), c)
    ratio(f"batch of {N} points, {ndir} direction(s)", lambda: law.update(states, slip, pressure), c)


def small():
    """The cost of the call itself: one point, one increment."""
    law = Law(mu=0.3, gcr=0.002, reference_pressure=100, ndir=1)
    states, slip, pressure = law.virgin(1), np.zeros(1), np.full(1, 100.0)
    out = law.update(states, slip, pressure)
    began = time.process_time()
    for _ in range(2000):
        law.update(states, slip, pressure, out=out)
    print(f"a call for one point: {(time.process_time() - began) / 2e-3:.1f} microseconds")


if __name__ == "__main__":
    print(f"{'':44s} {'Python':>11s} {'C':>11s}  ratio")
    for directions in (1, 2):
        history(directions)
        batch(directions)
    small()
