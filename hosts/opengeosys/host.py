"""The friction box in OpenGeoSys: an unmodified release, the law loaded through its MFront interface.

OpenGeoSys takes small-strain laws only, so the contact is a thin layer of solid elements: jump = strain x thickness.
"""

import os
import re
import subprocess
import sys
import time
from pathlib import Path
from string import Template

import meshio
import numpy as np

from box import CRITICAL_SLIP, EXPONENT, FRICTION, NORMAL_STIFFNESS, POISSON, PRESSURE, YOUNG

HERE = Path(__file__).parent
THICKNESS = 0.01
DENSITY = (
    "<phases><phase><type>Solid</type><properties><property>"
    "<name>density</name><type>Constant</type><value>1</value>"
    "</property></properties></phase></phases>"
)


class Refused(RuntimeError):
    """The run ended with an error; the text is what OpenGeoSys printed."""


def layer(box):
    """Connectivity of the layer's elements."""
    if box.dim == 3:
        return box.contact
    return box.contact[:, [0, 1, 3, 2]]


def write_meshes(box, directory):
    kind = "quad" if box.dim == 2 else "hexahedron"
    points = np.hstack([box.nodes, np.zeros((len(box.nodes), 3 - box.dim))])
    cells = np.vstack([box.blocks, layer(box)])
    material = np.repeat(np.array([0, 1], np.int32), [len(box.blocks), len(box.contact)])
    meshio.Mesh(points, [(kind, cells)], cell_data={"MaterialIDs": [material]}).write(directory / "box.vtu")
    for name in ("bottom", "top", "lower", "upper"):
        numbers = np.unique(getattr(box, name))
        vertices = np.arange(len(numbers))[:, None]
        ids = {"bulk_node_ids": numbers.astype(np.uint64)}
        meshio.Mesh(points[numbers], [("vertex", vertices)], point_data=ids).write(directory / f"{name}.vtu")


def condition(mesh, component, parameter):
    return (
        f"<boundary_condition><mesh>{mesh}</mesh><type>Dirichlet</type>"
        f"<component>{component}</component><parameter>{parameter}</parameter></boundary_condition>"
    )


def fixed_steps(start, end):
    """A step for every displacement of the path."""
    return (
        f"<type>FixedTimeStepping</type><t_initial>{start}</t_initial><t_end>{end}</t_end>"
        f"<timesteps><pair><repeat>{end - start}</repeat><delta_t>1</delta_t></pair></timesteps>"
    )


def deck(box, method, library, path, start=0, stepping=None, most_iterations=50, rigid=False, **changed):
    """The project file.

    `start`: the step to go on from, its output being box.vtu; `rigid`: all nodes of the blocks move as the outer faces
    do, for a sheared box; others: material properties.
    """
    normal = box.dim - 1
    zeros = " ".join(["0"] * box.dim)
    initial = f"<type>Constant</type><values>{zeros}</values>"
    if start:
        initial = "<type>MeshNode</type><field_name>displacement</field_name>"
    values = {
        "young": YOUNG, "poisson": POISSON, "one": 1.0, "zero": 0.0,
        "mu": FRICTION, "gcr": CRITICAL_SLIP, "chi": EXPONENT[method], "kn": NORMAL_STIFFNESS, "gap": 0.0,
        "reference_pressure": PRESSURE, "thickness": box.layer,
        "direction_0": box.direction[0], "direction_1": box.direction[-1],
    } | changed
    held, moved = ("lower", "upper") if rigid else ("bottom", "top")
    conditions = [condition(held, component, "zero") for component in range(box.dim)]
    conditions += [condition(moved, component, f"moved_{component}") for component in range(normal)]
    if box.case == "sheared":
        conditions += [condition("lower", normal, "zero"), condition("upper", normal, "closed")]
    else:
        conditions.append(condition("top", normal, "closed"))
    # Step 1 presses the blocks together, with the path's first displacement; the path follows.
    times = range(len(path) + 1)
    text = Template((HERE / "box.prj").read_text())
    return text.substitute(
        library=library, zeros=zeros, initial=initial, density=DENSITY, dim=box.dim, most_iterations=most_iterations,
        stepping=stepping or fixed_steps(start, len(path)), times=" ".join(map(str, times)),
        closing=" ".join(map(repr, [0.0] + [-box.closing] * len(path))),
        path=" ".join(map(repr, [0.0, *map(float, path)])),
        parameters="\n    ".join(
            f"<parameter><name>{name}</name><type>Constant</type><value>{float(value)!r}</value></parameter>"
            for name, value in values.items()
        ),
        conditions="\n        ".join(conditions),
    )


def execute(directory, threads=1, progress=None):
    """Runs box.prj there; the iterations of each step, and the seconds. Raises Refused."""
    environment = os.environ | {"OMP_NUM_THREADS": str(threads), "OGS_ASM_THREADS": str(threads)}
    program = Path(sys.executable).parent / "ogs"
    began = time.perf_counter()
    with subprocess.Popen(
        [program, "box.prj", "-o", "."], cwd=directory, env=environment, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    ) as process:
        lines = []
        for line in process.stdout:
            lines.append(line)
            if progress and re.search(r"Time step #\d+ took", line):
                progress.update()
    seconds = time.perf_counter() - began
    (directory / "log.txt").write_text("".join(lines))
    if process.returncode != 0:
        telling = [line for line in lines if re.match("error|critical|warning", line) or "mepc" in line]
        raise Refused("".join(telling) + f"(all of it: {directory / 'log.txt'})")
    iterations, count = [], 0
    for line in lines:
        if "Iteration #" in line and "took" in line:
            count += 1
        if re.search(r"Time step #[1-9]\d* took", line):  # 0 is the start
            iterations.append(count)
            count = 0
    return iterations, seconds


def read(box, directory, numbers):
    """Force along the direction of the motion, normal force and dissipated energy, of these steps."""
    forces, normals, dissipated = [], [], []
    for number in numbers:
        mesh = meshio.read(directory / f"step_{number}.vtu")
        # Per area; all points of the regular mesh have the same share.
        points = mesh.field_data["material_state_variable_DissipatedEnergy_ip"]
        dissipated.append(float(points.mean() * box.area))
        nodal = mesh.point_data["NodalForces"].reshape(len(box.nodes), -1)
        pressed = box.upper if box.case == "sheared" else box.top
        forces.append(float(nodal[box.top].sum(axis=0)[: box.dim - 1] @ box.direction))
        normals.append(float(-nodal[pressed, box.dim - 1].sum()))
    return forces, normals, dissipated
