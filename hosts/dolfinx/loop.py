# SPDX-License-Identifier: MIT OR Apache-2.0
"""One history of a model from beginning to end, or from its checkpoint on."""

import time

import numpy as np

from files import Checkpoint, Fields, write_table
from host import tighten


def follow(solver, folder, checkpoint_every=0, resume=False, fields_every=0, stop=None, name="loop"):
    """Goes through the history: rows of the table, also written to folder/NAME.csv.

    checkpoint_every -- steps between checkpoints (folder/NAME.h5), 0: none
    resume           -- go on from that file if it is there
    fields_every     -- steps between fields (folder/NAME-from-STEP.xdmf), 0: none
    stop             -- number of steps after which the run ends, None: all"""
    model, comm = solver.model, solver.comm
    folder.mkdir(parents=True, exist_ok=True)
    checkpoint = Checkpoint(folder / f"{name}.h5", solver)
    began = time.perf_counter()
    if resume and checkpoint.exists():
        done, now, rows = checkpoint.read()
        solver.say(f"{name}: goes on after step {done} of {len(model.history)}")
    else:
        done, rows = 0, []
        if model.tightened:
            now = tighten(solver)
            rows.append(solver.row(now))
        else:
            now = solver.start()
    fields = Fields(folder / f"{name}-from-{done}.xdmf", solver) if fields_every else None
    last = len(model.history) if stop is None else min(stop, len(model.history))
    for number in range(done + 1, last + 1):
        since = time.perf_counter()
        load = np.array([model.history[number - 1], now.load[1]])
        now = solver.advance(now, load, f"{name}, step {number}: ")
        row = solver.row(now)
        rows.append(row)
        solver.say(
            f"{name}, step {number}/{last}: displacement {row['displacement']:.6g} mm, force {row['force']:.6g} N, "
            f"{row['iterations']} iterations{f', {now.cuts} cuts' if now.cuts else ''}, "
            f"{time.perf_counter() - since:.2f} s")
        if fields and (number % fields_every == 0 or number == last):
            fields.write(number, now)
        if checkpoint_every and (number % checkpoint_every == 0 or number == last):
            checkpoint.write(number, now, rows)
    if comm.rank == 0 and rows:
        write_table(folder / f"{name}.csv", rows)
    solver.say(f"{name}: {len(rows)} rows, {sum(row['iterations'] for row in rows):.0f} iterations, "
               f"{time.perf_counter() - began:.1f} s")
    return rows
