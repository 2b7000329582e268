#!/usr/bin/env python3
"""Runs the friction box in CalculiX, and the same mesh in OpenGeoSys, and compares point by point.

Needs the program that hosts/calculix/build.sh builds; without it everything is skipped. See README.md beside this file.
"""

import importlib.util
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
import numpy as np
from tqdm import tqdm

import common
import host
import reference
from box import EXPONENT, FRICTION, Box, cycle, history
from table import Results

THICKNESS = 0.01
ELEMENT = f"C3D8 layer, {THICKNESS} mm"
# What must be refused, and a word of the message.
REFUSED = {
    "too few state variables": ({"states": 10}, "NSTATV"),
    "no thickness": ({"parameters": [0.3, 2e-3, 2.5, *[0.0] * 17, 2.0]}, "PROPS(23)"),
}


def opengeosys():
    """hosts/opengeosys/host.py, which has the name of the host.py here."""
    spec = importlib.util.spec_from_file_location("opengeosys_host", HERE.parent / "opengeosys/host.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def main():
    options = common.options("calculix", __doc__)
    results = Results("calculix")
    try:
        program = host.find_program()
    except host.Unable as error:
        results.skip("everything", str(error))
        results.write(options.output)
        return 0
    divisions, steps = ((2, 2, 1), 5) if options.small else ((4, 4, 2), 5)
    for case in ("sheared", "pressed"):
        run_box(program, Box(case, divisions, THICKNESS), steps, options, results)
    worst_day(program, options, results)
    return 0 if results.write(options.output) else 1


def run_box(program, box, steps, options, results):
    """Both exponents on one mesh."""
    path, rows = history(steps), cycle(steps)
    ogs, curves = opengeosys(), []
    for method in tqdm(EXPONENT, desc=f"calculix {box.name}", unit="run", disable=None):
        name = f"{box.name} {method}"
        directory = options.output / f"{box.name}_{method}"
        directory.mkdir(exist_ok=True)
        (directory / "box.inp").write_text(host.deck(box, method, path))
        iterations, seconds = host.execute(program, directory, options.library)
        force, normal = host.read(box, directory)
        columns = {"displacement": path, "force": force, "normal_force": normal, "iterations": iterations}
        common.write_csv(options.output / f"{box.name}_{method}.csv", columns, f"{ELEMENT}, {steps} steps per branch")
        limit = FRICTION * normal
        plateau = np.abs(force / limit)[[2 * steps, 3 * steps]].min()
        # The program prints seven digits.
        results.check(f"{name}: plateau / (mu N) - 1", abs(plateau - 1), 1e-4)
        results.check(f"{name}: most |force| / (mu N) - 1", np.abs(force / limit).max() - 1, 1e-6)
        if box.case == "sheared":
            exact = reference.sheared(path, method) * box.area
            error = np.abs(force - exact).max() / limit[0]
            results.check(f"{name}: force against the closed form, over mu N", error, 1e-6)

        directory = options.output / f"{box.name}_{method}_opengeosys"
        directory.mkdir(exist_ok=True)
        ogs.write_meshes(box, directory)
        (directory / "box.prj").write_text(ogs.deck(box, method, options.library, path))
        ogs.execute(directory)
        other = np.array(ogs.read(box, directory, range(1, len(path) + 1))[0])
        difference = np.abs(force - other).max() / limit[0]
        results.check(f"{name}: force against OpenGeoSys, over mu N", difference, 1e-4)
        results.row(
            f"{name}: {ELEMENT}", steps=len(path), iterations=sum(iterations), plateau=plateau,
            loop_area=reference.loop_area(path[rows], force[rows]), seconds=seconds, difference=difference,
            reference="OpenGeoSys")
        curves.append((f"{method}: CalculiX", path, force / limit, "o" if method == "memory" else "s"))
        curves.append((f"{method}: OpenGeoSys", path, other / limit, "-"))
    title = f"Friction box in CalculiX, {box.name.replace('_', ' ')}"
    common.picture(options.output / f"{box.name}.png", title, curves)


def worst_day(program, options, results):
    """Threads, and input that must be refused."""
    box, path = Box("pressed", (2, 2, 1), THICKNESS), history(3)
    forces = []
    for threads in (1, 2):
        directory = options.output / f"threads_{threads}"
        directory.mkdir(exist_ok=True)
        (directory / "box.inp").write_text(host.deck(box, "memory", path))
        host.execute(program, directory, options.library, threads)
        forces.append(host.read(box, directory))
    difference = np.abs(forces[0][0] - forces[1][0]).max() / (FRICTION * forces[0][1][0])
    results.check("2 threads against 1: force, over mu N", difference, 1e-6)
    for what, (changed, word) in REFUSED.items():
        directory = options.output / "refused"
        directory.mkdir(exist_ok=True)
        (directory / "box.inp").write_text(host.deck(box, "memory", path, **changed))
        said = []
        try:
            host.execute(program, directory, options.library)
        except host.Refused as error:
            said = [line for line in str(error).splitlines() if "mepc UMAT:" in line and word in line]
            if said:
                print(f"    {said[0].strip()}")
        results.check(f"{what}: the run ends with our message (0 is yes)", float(not said), 0.0)


if __name__ == "__main__":
    sys.exit(main())
