#!/usr/bin/env python3
"""Runs the friction box in Kratos: loops as CSV and pictures, result rows, and what must hold.

See README.md beside this file.
"""

import os
import sys

os.environ.setdefault("OMP_NUM_THREADS", "1")  # more threads are slower here
import numpy as np  # noqa: E402
from tqdm import tqdm  # noqa: E402

import common  # noqa: E402
import reference  # noqa: E402
import worst_day  # noqa: E402
from box import AMPLITUDE, FRICTION, Box, cycle, history  # noqa: E402
from host import Model, interface_element  # noqa: E402
from table import Results  # noqa: E402

REPEATS = 5  # of the timed runs; the fastest counts


def turning_points(steps):
    """The rows of the cycle's turning points: there everything slips."""
    return [2 * steps, 3 * steps]


def main():
    options = common.options("kratos", __doc__)
    results = Results("kratos")
    meshes = [((4, 2), 10), ((2, 2, 1), 5)] if options.small else [((12, 6), 20), ((4, 4, 2), 10)]
    for divisions, steps in meshes:
        for case in ("sheared", "pressed"):
            run_box(Box(case, divisions), steps, options, results)
    compare_time(Box("pressed", meshes[0][0]), meshes[0][1], options, results)
    worst_day.run(options, results)
    return 0 if results.write(options.output) else 1


def run_box(box, steps, options, results):
    """All laws on one mesh."""
    whole, rows = history(steps), cycle(steps)
    methods = ["memory", "penalty"] + (["coulomb"] if box.dim == 2 else [])
    loops, curves = {}, []
    for method in methods:
        path = whole[: rows.stop] if method == "coulomb" else whole
        # Under the consistent rule the penalty law has the stiffness of the reference pressure everywhere, as Kratos' has.
        model = Model(box, method, options.library)
        record = model.run(path, lambda p: tqdm(p, desc=f"kratos {box.name} {method}", unit="step", disable=None))
        columns = {name: np.array(values) for name, values in record.columns().items()}
        loops[method] = columns
        element = interface_element(box.dim, method)
        common.write_csv(options.output / f"{box.name}_{method}.csv", columns, f"{element}, {steps} steps per branch")
        limit = FRICTION * columns["normal_force"]
        ratio = columns["force"] / limit
        style = {"memory": "o", "penalty": "s-", "coulomb": "x"}[method]
        curves.append((f"{method}: {element}", path, ratio, style))
        area = reference.loop_area(path[rows], columns["force"][rows])
        plateau = np.abs(ratio[turning_points(steps)]).min()
        difference, compared = None, ""
        name = f"{box.name} {method}"
        if method == "coulomb":
            difference = against_own_law(box, steps, path, loops, results)
            compared = "penalty, first loading"
        else:
            results.check(f"{name}: plateau / (mu N) - 1", abs(plateau - 1), 1e-4)
            results.check(f"{name}: most |force| / (mu N) - 1", np.abs(ratio).max() - 1, 1e-9)
            dissipated = np.diff(columns["dissipated_energy"][[rows.start, rows.stop - 1]])[0]
            # The force is sampled at the steps, the law integrates its curve exactly: trapezoids, of second order.
            results.check(f"{name}: loop area / dissipated energy - 1", abs(area / dissipated - 1), 1.5 / steps**2)
            if box.case == "sheared":
                exact = reference.sheared(path, method) * box.area
                difference, compared = np.abs(columns["force"] - exact).max() / limit[0], "closed form"
                results.check(f"{name}: force against the closed form, over mu N", difference, 1e-7)
        results.row(
            f"{box.name} {method}: {element}", steps=len(path), iterations=sum(record.iterations), plateau=plateau,
            loop_area=area, seconds=record.seconds, difference=difference, reference=compared)
    if box.case == "sheared":
        fine = history(10 * steps)
        curves.append(("memory: closed form", fine, reference.sheared(fine, "memory") * box.area / limit[0], "k-"))
    common.picture(options.output / f"{box.name}.png", f"Friction box in Kratos, {box.name.replace('_', ' ')}", curves)


def against_own_law(box, steps, path, loops, results):
    """The penalty (exponent 1) against Kratos' own Coulomb law; their largest difference at first loading.

    In this release the element of Kratos' own law does not keep its state from step to step: unloading goes back
    along the loading curve and the loop has no area. Then its loop follows from its first loading by Masing's rule.
    """
    own, ours = loops["coulomb"], loops["penalty"]
    rows, first = cycle(steps), slice(0, steps + 1)
    limit = FRICTION * ours["normal_force"]
    difference = np.abs(own["force"][first] - ours["force"][first]).max() / limit[0]
    area = reference.loop_area(path[rows], ours["force"][rows])
    own_area = reference.loop_area(path[rows], own["force"][rows])
    name = f"{box.name}: penalty against Kratos' Coulomb law"
    if own_area < 0.01 * area:
        print(f"  {box.name}: Kratos' own law keeps no state: area of its loop {own_area:.2g}, of ours {area:.4g}")
        loading = np.trapezoid(own["force"][first], path[first])
        own_area = 8 * loading - 4 * AMPLITUDE * own["force"][steps]
        loading = np.trapezoid(ours["force"][first], path[first])
        area = 8 * loading - 4 * AMPLITUDE * ours["force"][steps]
        name += " (Masing's rule)"
    results.check(f"{name}: loop area", abs(area / own_area - 1), 0.01)
    plateaus = [abs(loop["force"][steps]) / (FRICTION * loop["normal_force"][steps]) for loop in (own, ours)]
    results.check(f"{box.name}: penalty against Kratos' Coulomb law: plateau", abs(plateaus[0] - plateaus[1]), 1e-3)
    if box.case == "sheared":
        results.check(f"{box.name}: penalty against Kratos' Coulomb law: force, over mu N", difference, 1e-7)
    return difference


def compare_time(box, steps, options, results):
    """The run time of the memory law over that of Kratos' own law, at first loading on the same mesh."""
    path = history(steps)[: steps + 1]
    best = {}
    for _ in range(REPEATS):  # alternating, so that other work on the machine hits both
        for method in ("memory", "coulomb"):
            record = Model(box, method, options.library).run(path)
            best[method] = min(best.get(method, (np.inf, 0)), (record.seconds, sum(record.iterations)))
    (memory, count), (own, own_count) = best["memory"], best["coulomb"]
    print(
        f"  first loading, {box.name}: memory {memory:.3f} s in {count} iterations, Kratos' own law {own:.3f} s in "
        f"{own_count}; an iteration takes {memory / count / (own / own_count):.2f} of its time")
    results.check(f"{box.name}: run time, memory over Kratos' own law", memory / own, 1.1)


if __name__ == "__main__":
    sys.exit(main())
