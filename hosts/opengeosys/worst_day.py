"""A host's worst day, in OpenGeoSys: restart, rejected steps, threads, input that must be refused."""

import re

import meshio
import numpy as np

import host
import reference
from box import AMPLITUDE, FRICTION, PRESSURE, TURNS, Box, history

DIVISIONS, STEPS = (2, 2, 1), 5
# Material properties that must be refused.
REFUSED = {"Exponent": {"chi": 0.5}, "Thickness": {"thickness": 0.0}}
# Halves the step and tries again when the iterations run out.
ADAPTIVE = """<type>IterationNumberBasedTimeStepping</type><t_initial>0</t_initial><t_end>{end}</t_end>
  <initial_dt>1</initial_dt><minimum_dt>0.06</minimum_dt><maximum_dt>1</maximum_dt>
  <number_iterations>1 5</number_iterations><multiplier>2 0.5</multiplier>"""
FEW_ITERATIONS = 5


def solve(options, name, box, path, threads=1, mesh=None, **deck):
    """One run of the deck; its directory."""
    directory = options.output / "worst_day" / name
    directory.mkdir(parents=True, exist_ok=True)
    for old in directory.glob("step*"):
        old.unlink()
    host.write_meshes(box, directory)
    if mesh:
        (directory / "box.vtu").write_bytes(mesh.read_bytes())
    (directory / "box.prj").write_text(host.deck(box, "memory", options.library, path, **deck))
    host.execute(directory, threads)
    return directory


def fields(file):
    """Everything in an output: displacements, forces, stresses, states."""
    mesh = meshio.read(file)
    nodes = {name: mesh.point_data[name] for name in ("displacement", "NodalForces")}
    return nodes | {name: values for name, values in mesh.field_data.items() if name.endswith("_ip")}


def last(directory):
    """The last output of a run."""
    return fields(max(directory.glob("step_*.vtu"), key=lambda file: int(file.stem.split("_")[1])))


def distance(one, other, names):
    return max(np.abs(one[name] - other[name]).max() for name in names)


def run(options, results):
    """All of it."""
    box = Box("pressed", DIVISIONS, host.THICKNESS)
    path = history(STEPS)
    whole_directory = solve(options, "whole", box, path)
    whole = last(whole_directory)

    middle = 3 * STEPS + STEPS // 2
    start = whole_directory / f"step_{middle}.vtu"
    directory = solve(options, "restart", box, path, mesh=start, start=middle)
    written, got = fields(start), fields(directory / "step_0.vtu")
    difference = distance(got, written, written)
    results.check(f"restart after step {middle}: state read against state written", difference, 0.0)
    # With every displacement prescribed the host cannot round anything: what is left is the law.
    rigid = Box("sheared", DIVISIONS, host.THICKNESS)
    without = solve(options, "rigid_whole", rigid, path, rigid=True)
    start = without / f"step_{middle}.vtu"
    resumed = last(solve(options, "rigid_restart", rigid, path, mesh=start, start=middle, rigid=True))
    states = [name for name in resumed if name.startswith("material_state_variable")]
    difference = distance(resumed, last(without), states)
    results.check(f"restart after step {middle}, rigid blocks: states at the end", difference, 0.0)
    # With elastic blocks OpenGeoSys goes on with other roundings of its own.
    scale = np.abs(whole["NodalForces"]).max()
    again = distance(last(directory), whole, ["NodalForces"]) / scale
    results.check(f"restart after step {middle}: forces at the end, over the largest", again, 1e-12)

    threads = last(solve(options, "threads", box, path, threads=2))
    difference = distance(threads, whole, ["NodalForces"]) / scale
    results.check("2 threads against 1: forces, over the largest", difference, 1e-9)

    sheared = Box("sheared", (1, 1, 1), host.THICKNESS)
    turns = AMPLITUDE * np.array(TURNS)  # one step per branch, if it were not for the rejections
    stepping = ADAPTIVE.format(end=len(turns))
    directory = solve(options, "rejected", sheared, turns, stepping=stepping, most_iterations=FEW_ITERATIONS)
    rejected = int(re.search(r"the rejected steps are (\d+)", (directory / "log.txt").read_text())[1])
    force = last(directory)["NodalForces"][sheared.top].sum(axis=0)[:2] @ sheared.direction
    exact = reference.sheared(turns, "memory")[-1] * sheared.area
    error = abs(force - exact) / (FRICTION * PRESSURE * sheared.area)
    results.check("rejected steps: there are some (0 is yes)", float(rejected == 0), 0.0)
    results.check(f"{rejected} rejected steps: force at the end against the closed form, over mu N", error, 1e-7)

    for what, changed in REFUSED.items():
        try:
            solve(options, f"refused_{what}", box, path, **changed)
            said = None
        except host.Refused as error:
            said = str(error)
        results.check(f"{what} out of range: the run ends with an error (0 is yes)", float(said is None), 0.0)
        ours = [line for line in (said or "").splitlines() if "mepc" in line and what in line]
        results.check(f"{what} out of range: our message is missing (1 is yes)", float(not ours), 0.0)
        print(f"    {ours[0].strip() if ours else 'nothing'}")
