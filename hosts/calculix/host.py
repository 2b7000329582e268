"""The friction box in CalculiX: the law is loaded as an external UMAT, in a thin layer of C3D8 elements.

Debian's own binary cannot load one and says nothing about it: `find_program` refuses a program that cannot.
"""

import os
import re
import shutil
import subprocess
import time
from pathlib import Path

import numpy as np

from box import CRITICAL_SLIP, EXPONENT, FRICTION, NORMAL_STIFFNESS, POISSON, PRESSURE, YOUNG

ROOT = Path(__file__).parents[2]
STATE_SIZE = 84
DIVERGENCE_CHECK, MOST_ITERATIONS = 200, 400
TOLERANCE = 1e-9  # of the residual, over the mean force


class Unable(RuntimeError):
    """There is no CalculiX that can load a library."""


class Refused(RuntimeError):
    """The run ended with an error; the text is what CalculiX printed."""


def find_program():
    """The program that build.sh made, or $CCX."""
    program = os.environ.get("CCX") or ROOT / "build/calculix/ccx"
    if not shutil.which(program):
        raise Unable(f"{program} is not there: hosts/calculix/build.sh builds it in about 3 minutes")
    symbols = subprocess.run(["nm", "-D", program], capture_output=True, text=True, check=True).stdout
    if "dlopen" not in symbols:
        raise Unable(f"{program} has no external behaviours: it would run the deck with a contact of no force")
    return Path(program).resolve()


def numbers(values, per_line=8):
    """Lines of a deck."""
    values = [repr(v) if isinstance(v, float) else str(v) for v in values]
    return "\n".join(",".join(values[i : i + per_line]) for i in range(0, len(values), per_line))


def deck(box, method, path, parameters=None, states=STATE_SIZE):
    """The input file."""
    def table(rows):
        return "\n".join(",".join(map(repr, row)) for row in rows)

    def members(nodes):
        return numbers(sorted(int(n) + 1 for n in np.unique(nodes)))

    def elements(cells, first):
        return "\n".join(
            ",".join(map(str, [first + i, *(int(n) + 1 for n in cell)])) for i, cell in enumerate(cells)
        )

    if parameters is None:
        # The reference pressure is the mean one.
        common = [FRICTION, CRITICAL_SLIP, EXPONENT[method], 0, PRESSURE, 0, NORMAL_STIFFNESS] + 13 * [0]
        # Layout 2: thin layer; scale 1; its thickness; the sticking tangent, because ccx symmetrises what it gets.
        parameters = [*common, 2, 1, box.layer, 1]
    nodes = table([(i, *map(float, point)) for i, point in enumerate(box.nodes, 1)])
    amplitude = [(0.0, 0.0)] + [(float(i), float(u)) for i, u in enumerate(path, 1)]
    closing = [(0.0, 0.0), (1.0, 1.0), (float(len(path)), 1.0)]
    conditions = ["*BOUNDARY", "BOTTOM,1,3"]
    if box.case == "sheared":
        conditions += ["*BOUNDARY", "LOWER,3,3", "*BOUNDARY,AMPLITUDE=CLOSING", f"UPPER,3,3,{-box.closing!r}"]
    else:
        conditions += ["*BOUNDARY,AMPLITUDE=CLOSING", f"TOP,3,3,{-box.closing!r}"]
    conditions.append("*BOUNDARY,AMPLITUDE=PATH")
    conditions += [f"TOP,{i},{i},{float(c)!r}" for i, c in enumerate(box.direction, 1)]
    return "\n".join([
        "*NODE,NSET=ALL", nodes,
        "*ELEMENT,TYPE=C3D8,ELSET=BLOCKS", elements(box.blocks, 1),
        "*ELEMENT,TYPE=C3D8,ELSET=LAYER", elements(box.contact, 1 + len(box.blocks)),
        *(f"*NSET,NSET={name.upper()}\n{members(getattr(box, name))}" for name in ("bottom", "top", "lower", "upper")),
        "*MATERIAL,NAME=STEEL", "*ELASTIC", f"{YOUNG!r},{POISSON!r}",
        # The name says: symbol umat_ of libMEPC.so. The constants are followed by the temperature they are for.
        "*MATERIAL,NAME=@ABAQUS_MEPC", f"*USER MATERIAL,CONSTANTS={len(parameters)}",
        numbers([*map(float, parameters), 0.0]), "*DEPVAR", str(states),
        "*SOLID SECTION,ELSET=BLOCKS,MATERIAL=STEEL", "*SOLID SECTION,ELSET=LAYER,MATERIAL=@ABAQUS_MEPC",
        "*AMPLITUDE,NAME=CLOSING,TIME=TOTAL TIME", table(closing),
        "*AMPLITUDE,NAME=PATH,TIME=TOTAL TIME", table(amplitude),
        f"*STEP,INC={len(path) + 1}", "*STATIC,DIRECT", f"1.,{len(path)}.",
        "*CONTROLS,PARAMETERS=TIME INCREMENTATION",
        ",".join(map(str, [DIVERGENCE_CHECK, DIVERGENCE_CHECK, DIVERGENCE_CHECK, MOST_ITERATIONS])),
        "*CONTROLS,PARAMETERS=FIELD", f"{TOLERANCE!r},1e-6",
        *conditions,
        "*NODE PRINT,NSET=TOP,TOTALS=ONLY", "RF",
        "*NODE PRINT,NSET=UPPER,TOTALS=ONLY", "RF",
        "*END STEP", "",
    ])


def execute(program, directory, library, threads=1):
    """Runs box.inp there; iterations of each increment, and seconds. Raises Refused."""
    link = directory / "libMEPC.so"  # ccx turns names into capitals
    link.unlink(missing_ok=True)
    link.symlink_to(Path(library).resolve())
    environment = os.environ | {"LD_LIBRARY_PATH": str(directory.resolve()), "OMP_NUM_THREADS": str(threads)}
    began = time.perf_counter()
    done = subprocess.run([program, "box"], cwd=directory, env=environment, capture_output=True, text=True)
    seconds = time.perf_counter() - began
    text = done.stdout + done.stderr
    (directory / "log.txt").write_text(text)
    if done.returncode != 0 or "*ERROR" in text:
        raise Refused(text)
    rows = [line.split() for line in (directory / "box.sta").read_text().splitlines()[2:]]
    return [int(row[3]) for row in rows], seconds


def read(box, directory):
    """Force along the direction of the motion, and normal force, of all increments."""
    totals = {"TOP": [], "UPPER": []}
    name = None
    for line in (directory / "box.dat").read_text().splitlines():
        if found := re.search(r"total force \(fx,fy,fz\) for set (\w+)", line):
            name = found[1]
        elif name and line.strip():
            totals[name].append([float(v) for v in line.split()])
            name = None
    top, upper = (np.array(totals[key]) for key in ("TOP", "UPPER"))
    return top[:, :2] @ box.direction, -(upper if box.case == "sheared" else top)[:, 2]
