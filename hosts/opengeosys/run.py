#!/usr/bin/env python3
"""Runs the friction box in OpenGeoSys: loops as CSV and pictures, result rows, and what must hold.

Run hosts/kratos/run.py with the same options before: its loops are compared with. See README.md beside this file.
"""

import sys

import numpy as np
from tqdm import tqdm

import common
import host
import reference
import worst_day
from box import EXPONENT, FRICTION, Box, cycle, history
from table import Results


def main():
    options = common.options("opengeosys", __doc__)
    results = Results("opengeosys")
    meshes = [((4, 2), 10), ((2, 2, 1), 5)] if options.small else [((12, 6), 20), ((4, 4, 2), 10)]
    for divisions, steps in meshes:
        for case in ("sheared", "pressed"):
            run_box(Box(case, divisions, host.THICKNESS), steps, options, results)
    worst_day.run(options, results)
    return 0 if results.write(options.output) else 1


def run_box(box, steps, options, results):
    """Both exponents on one mesh."""
    path, rows = history(steps), cycle(steps)
    element = f"{'QUAD4' if box.dim == 2 else 'HEX8'} layer, {box.layer} mm"
    curves = []
    for method in EXPONENT:
        name = f"{box.name} {method}"
        directory = options.output / f"{box.name}_{method}"
        directory.mkdir(exist_ok=True)
        host.write_meshes(box, directory)
        (directory / "box.prj").write_text(host.deck(box, method, options.library, path))
        with tqdm(total=len(path), desc=f"opengeosys {name}", unit="step", disable=None) as progress:
            iterations, seconds = host.execute(directory, progress=progress)
        force, normal, dissipated = map(np.array, host.read(box, directory, range(1, len(path) + 1)))
        columns = {
            "displacement": path, "force": force, "normal_force": normal, "dissipated_energy": dissipated,
            "iterations": iterations,
        }
        common.write_csv(options.output / f"{box.name}_{method}.csv", columns, f"{element}, {steps} steps per branch")
        ratio = force / (FRICTION * normal)
        curves.append((f"{method}: {element}", path, ratio, "o" if method == "memory" else "s"))
        plateau = np.abs(ratio[[2 * steps, 3 * steps]]).min()
        area = reference.loop_area(path[rows], force[rows])
        results.check(f"{name}: plateau / (mu N) - 1", abs(plateau - 1), 1e-4)
        results.check(f"{name}: most |force| / (mu N) - 1", np.abs(ratio).max() - 1, 1e-9)
        lost = dissipated[rows.stop - 1] - dissipated[rows.start]
        results.check(f"{name}: loop area / dissipated energy - 1", abs(area / lost - 1), 1.5 / steps**2)
        difference, compared = None, ""
        if box.case == "sheared":
            exact = reference.sheared(path, method) * box.area
            difference, compared = np.abs(force - exact).max() / (FRICTION * normal[0]), "closed form"
            results.check(f"{name}: force against the closed form, over mu N", difference, 1e-7)
        else:
            kratos = common.read_csv(options.output.parent / "kratos" / f"{box.name}_{method}.csv")
            if kratos is None or len(kratos["force"]) != len(path):  # not run, or with other options
                results.skip(f"{name}: comparison with Kratos", "no such loop of Kratos (run it first, same options)")
            else:
                other = kratos["force"] / (FRICTION * kratos["normal_force"])
                curves.append((f"{method}: Kratos", path, other, "-"))
                difference, compared = np.abs(ratio - other).max(), "Kratos"
                # Other elements and points (2 x 2 (x 2) of Gauss here, the nodes there), and a layer of some thickness.
                results.check(f"{name}: force / (mu N) against Kratos", difference, 0.02)
        results.row(
            f"{name}: {element}", steps=len(path), iterations=sum(iterations), plateau=plateau, loop_area=area,
            seconds=seconds, difference=difference, reference=compared)
    if box.case == "sheared":
        fine, limit = history(10 * steps), FRICTION * normal[0] / box.area
        curves += [(f"{m}: closed form", fine, reference.sheared(fine, m) / limit, "-") for m in EXPONENT]
    title = f"Friction box in OpenGeoSys, {box.name.replace('_', ' ')}"
    common.picture(options.output / f"{box.name}.png", title, curves)


if __name__ == "__main__":
    sys.exit(main())
