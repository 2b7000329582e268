# SPDX-License-Identifier: MIT OR Apache-2.0
"""Runs the lap joint's studies and keeps their results: loops and tables as CSV, with what they were made with.

    study.py cases         the 13 cases of Table 1, identified by least squares and by the paper's procedure
    study.py methods       three preloads and friction coefficients, three contact methods (Fig. 9 and 10)
    study.py blind         a case nobody has tuned to: predicted from the paper's tables, then run
    study.py convergence   finer meshes and steps
    study.py sensitivity   kn, gcr, chi, reference pressure, resolution; the thread as a contact pair
    study.py maps          pressure and status on the plate interface through a cycle, for the pictures
    study.py paper-size    one loop on a mesh of the paper's size (see there for time and memory)
    study.py reference     one loop on a coarse mesh; with --check compared with the result kept (guards drift only)
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy: one core is enough but for the paper's size

import argparse
import csv
import json
import resource
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator
from tqdm import tqdm

import paper  # noqa: E402
from contact import parts  # noqa: E402
from geometry import MESHES, Geometry  # noqa: E402
from joint import Case, interface, run  # noqa: E402
from loops import ROOT, identify, provenance, read_csv, write_csv  # noqa: E402

HERE = Path(__file__).resolve().parent
RESULTS, BUILD = HERE / "results", ROOT / "build/studies/lap_joint"
REFERENCE = Case("P900", **paper.REFERENCE)
PLATES = 20 * 20 - np.pi * 3.5**2  # mm2, contact of the plates
COLUMNS = ("case", "preload_N", "mu", "amplitude_mm", "k_alpha_N_per_mm", "F_s_N", "X_s_mm", "kappa",
           "dissipation_Nmm", "k_t_N_per_mm", "flag")


def table_1():
    """The 13 distinct cases."""
    return (
        [replace(REFERENCE, name=f"P{P}", preload=P) for P in paper.PRELOAD]
        + [replace(REFERENCE, name=f"mu{mu}", mu=mu) for mu in paper.FRICTION if mu != REFERENCE.mu]
        + [replace(REFERENCE, name=f"A{A:.3f}", amplitude=A) for A in paper.AMPLITUDE if A != REFERENCE.amplitude]
    )


# --- running and writing ----------------------------------------------------------------------------------------------


def model(mesh="study", geometry=Geometry(), progress=False):
    """Mesh and condensed structure; kept in build/, since one serves every case."""
    file = BUILD / f"{mesh}{'-thread' if geometry.thread_contact else ''}.npz"
    return interface(file, geometry, MESHES[mesh], progress=progress)


def measured(loop):
    """The last cycle as a rig with a sinusoidal drive records it: even in time, 200 points per branch."""
    cycle = loop.last_cycle()
    displacement, force = loop.displacement[cycle], loop.force[cycle]
    turn = int(np.argmin(displacement))
    swing = loop.displacement.max() * np.cos(np.linspace(0, np.pi, 201))
    down = PchipInterpolator(displacement[turn::-1], force[turn::-1])(swing)
    up = PchipInterpolator(displacement[turn:], force[turn:])(swing[::-1])
    return {"displacement": np.concatenate([swing, swing[-2::-1]]), "force": np.concatenate([down, up[1:]])}


def identified(loop, name):
    """What the tool makes of the loop as a rig records it."""
    file = BUILD / "measured" / f"{name}.csv"
    write_csv(file, measured(loop), "for mepc identify")
    return identify(file)


def slopes(loop):
    """Slope just after the reversals, and how much the slope of gross slip changes in the last two fifths of a branch."""
    first, bends = [], []
    cycle = loop.last_cycle()
    turn = cycle.start + int(np.argmin(loop.displacement[cycle]))
    for branch in (slice(cycle.start, turn + 1), slice(turn, None)):
        displacement, force = loop.displacement[branch], loop.force[branch]
        first.append((force[1] - force[0]) / (displacement[1] - displacement[0]))
        towards = np.sign(displacement[-1] - displacement[0])
        at = np.array([0.2, 0.6, 1.0]) * np.abs(displacement[-1])
        before, last = np.diff(np.interp(at, towards * displacement, force))
        bends.append(abs(last / before - 1))
    return np.mean(first), max(bends)


def loop_of(case, mesh="study", geometry=Geometry(), keep=False):
    """Runs a case and identifies its loop: rows by least squares and by the paper's procedure, and more figures.

    The loop is written to results/loops if it is to be kept, else to build/."""
    began = time.perf_counter()
    loop = run(case, *model(mesh, geometry), progress=False)
    seconds = time.perf_counter() - began
    write_csv(
        (RESULTS if keep else BUILD) / "loops" / f"{case.name}.csv",
        {"displacement": loop.displacement, "force": loop.force, "bolt_force": loop.bolt,
         "dissipated": np.cumsum(loop.dissipated), "iterations": loop.iterations},
        f"{case}; mm, N, N mm",
    )
    found = identified(loop, case.name)

    first_slope, bend = slopes(loop)
    # Head and nut lift off at their rim, more and more with the displacement: then no straight line is there to be found.
    flags = ([] if found["reliable"] else ["no gross slip"]) + (["residual line curved"] if bend > 0.025 else [])
    state = {"case": case.name, "preload_N": case.preload, "mu": case.mu, "amplitude_mm": case.amplitude}

    def row(parameters):
        values = [parameters[key] for key in ("k_alpha", "F_s", "X_s", "kappa")]
        stick = (2.5 + parameters["kappa"]) * parameters["F_s"] / parameters["X_s"] + parameters["k_alpha"]
        return {**state, **dict(zip(COLUMNS[4:], [*values, loop.area(), stick, "; ".join(flags)]))}

    cycle = loop.last_cycle()
    fitted = row(found)
    more = {
        **fitted,
        "first_slope_N_per_mm": first_slope,
        "F_max_N": np.ptp(loop.force[cycle]) / 2,
        "library_dissipation_Nmm": loop.dissipated[cycle.start + 1:].sum(),
        "residual_rms_N": found["residual_rms"],
        "bolt_min_N": loop.bolt.min(),
        "bolt_max_N": loop.bolt.max(),
        "iterations": loop.iterations[1:].mean(),
        "seconds": round(seconds, 1),
    }
    return fitted, row(found["paper"]), more


def shown(value):
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def write_table(name, table, echo=True):
    """A list of rows (dicts with the same keys) as results/NAME.csv, and on the screen."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    with (RESULTS / f"{name}.csv").open("w", newline="") as out:
        writer = csv.DictWriter(out, list(table[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows({key: shown(value) for key, value in row.items()} for row in table)
    print(f"{name}:")
    for row in [{key: key for key in table[0]}, *table]:
        print(" ".join(f"{shown(value):>12.12}" for value in row.values()))


def all_of(work, description, jobs):
    """Results of loop_of for (arguments, keywords), in order; with a progress bar."""
    if jobs == 1:
        return [loop_of(*given, **named) for given, named in tqdm(work, desc=description, unit="loop")]
    with ProcessPoolExecutor(jobs) as pool:
        futures = [pool.submit(loop_of, *given, **named) for given, named in work]
        return [future.result() for future in tqdm(futures, desc=description, unit="loop")]


def note(topic, **figures):
    """Adds to provenance.json what a topic was made with."""
    file = RESULTS / "provenance.json"
    old = json.loads(file.read_text()) if file.exists() else {}
    old[topic] = provenance(**figures)
    file.write_text(json.dumps(dict(sorted(old.items())), indent=1) + "\n")


# --- the studies ------------------------------------------------------------------------------------------------------


def cases(jobs):
    model(progress=True)
    done = all_of([((case,), {"keep": True}) for case in table_1()], "Table 1", jobs)
    write_table("identified", [fitted for fitted, _, _ in done])
    write_table("identified_paper_procedure", [row for _, row, _ in done])
    write_table("cases_more", [more for _, _, more in done])


def methods(jobs):
    model(progress=True)
    states = {327: 0.29, 592: 0.37, 902: 0.42}
    work = [
        ((replace(REFERENCE, name=f"P{P}-{method}", preload=P, mu=mu, method=method),), {"keep": True})
        for P, mu in states.items() for method in ("penalty", "memory", "Lagrange")
    ]
    done = all_of(work, "three methods", jobs)
    write_table("methods", [
        {"method": given[0].method, **{key: value for key, value in more.items() if key != "flag"}}
        for (given, _), (_, _, more) in zip(work, done)
    ])


def blind(jobs):
    case = replace(REFERENCE, name="P800-mu.35", preload=800, mu=0.35)
    predicted = paper.predict(case.preload, case.mu, case.amplitude)
    print("predicted from the paper's tables:", {key: shown(value) for key, value in predicted.items()})
    model(progress=True)
    (fitted, _, _), = all_of([((case,), {"keep": True})], "blind case", jobs)
    write_table("blind", [
        {"quantity": key, "predicted": value, "run": fitted[key], "difference_percent": 100 * (fitted[key] / value - 1)}
        for key, value in predicted.items()
    ])


def convergence(jobs):
    work, label = [], []
    for mesh in ("coarse", "study", "fine"):
        grid, _ = model(mesh, progress=True)
        work.append(((replace(REFERENCE, name=f"P900-{mesh}"), mesh), {}))
        label.append({"mesh": mesh, "nodes": len(grid.points), "increments": 5 * REFERENCE.quarter})
    for quarter in (8, 32, 64):
        work.append(((replace(REFERENCE, name=f"P900-{5 * quarter}", quarter=quarter),), {}))
        label.append({**label[1], "increments": 5 * quarter})
    done = all_of(work, "meshes and steps", jobs)
    write_table("convergence", [{**kind, **more} for kind, (_, _, more) in zip(label, done)])


def sensitivity(jobs):
    changes = [
        {}, {"kn": 1e5}, {"kn": 1e6}, {"gcr": 2e-3}, {"gcr": 4e-3}, {"chi": 1.5}, {"chi": 3.5}, 
        {"reference_pressure": REFERENCE.preload / PLATES},
    ]
    named = {" ".join(f"{key}={value:g}" for key, value in change.items()) or "reference": change for change in changes}
    # The paper's fifth pair. Its thread carries the bolt force by flanks smeared on a cylinder.
    thread = Geometry(thread_contact=True)
    model(progress=True), model(geometry=thread, progress=True)
    work = [((replace(REFERENCE, name=name, **change),), {}) for name, change in named.items()]
    work.append(((replace(REFERENCE, name="thread in contact"), "study", thread), {}))
    work.append(((replace(REFERENCE, name="thread in contact, P300", preload=300), "study", thread), {}))
    done = all_of(work, "sensitivity", jobs)
    write_table("sensitivity", [more for _, _, more in done])


def maps(_):
    """Pressure, traction and status on the plate interface through the last cycle of the reference case."""
    mesh, structure = model(progress=True)
    loop = run(replace(REFERENCE, name="maps"), mesh, structure)
    pair = next(pair for pair in mesh.pairs if pair.name == "plate-plate")
    part = parts(mesh.pairs)[pair.name]
    x, y, _ = mesh.points[pair.lower].T
    frames = []
    for number in range(loop.last_cycle().start, len(loop.steps)):
        step = loop.steps[number]
        normal, along, across = (-step.forces.reshape(-1, 3)[part] / pair.area[:, None]).T
        status = step.states[pair.name][:, 0]
        frames.append(np.column_stack([
            np.full(len(x), number), np.full(len(x), loop.displacement[number]), np.full(len(x), loop.force[number]),
            x, y, normal, -along, -across, status,
        ]))
    names = ("increment", "displacement", "force", "x", "y", "pressure", "traction_x", "traction_y", "status")
    table = np.vstack(frames)
    write_csv(BUILD / "maps.csv", dict(zip(names, table.T)), "mm, N, MPa; 0 open, 1 stick, 2 micro-slip, 3 gross slip")
    np.savetxt(BUILD / "maps-faces.csv", pair.faces, fmt="%d", delimiter=",")


def paper_size(_):
    began = time.perf_counter()
    mesh, structure = model("paper", progress=True)
    condensed = time.perf_counter()
    case = replace(REFERENCE, name="P900-paper-size")
    loop = run(case, mesh, structure)
    write_csv(RESULTS / "loops" / f"{case.name}.csv", {"displacement": loop.displacement, "force": loop.force}, str(case))
    found = identified(loop, case.name)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    write_table("paper_size", [{
        "nodes": len(mesh.points), "elements": len(mesh.hexahedra), "openings": len(structure.stiffness),
        "seconds_condensing": round(condensed - began), "seconds_loop": round(time.perf_counter() - condensed),
        "peak_GiB": round(peak, 1), "threads": int(os.environ["OMP_NUM_THREADS"]),
        **{key: found[key] for key in ("F_s", "X_s", "k_alpha", "kappa")}, "dissipation_Nmm": loop.area(),
    }])


def reference(check):
    """One loop on the coarse mesh."""
    mesh, structure = model("coarse", progress=True)
    loop = run(replace(REFERENCE, name="coarse reference"), mesh, structure)
    file = RESULTS / "reference.csv"
    columns = {"displacement": loop.displacement, "force": loop.force}
    if not check:
        write_csv(file, columns, "own result on the coarse mesh: guards drift only")
        return
    kept = read_csv(file)
    drift = np.abs(columns["force"] - kept["force"]).max() / np.ptp(kept["force"])
    balance = loop.dissipated[loop.last_cycle().start + 1:].sum() / loop.area() - 1
    limit = REFERENCE.mu * REFERENCE.preload
    plateau = identified(loop, "reference")["F_s"] / limit
    print(f"drift from the kept result {drift:.1e} of the swing; dissipation over loop area - 1: {balance:.1e}; "
          f"F_s / (mu P) {plateau:.4f}")
    if not (drift < 1e-6 and abs(balance) < 5e-3 and 0.97 < plateau < 1.03):
        sys.exit("reference: outside its bounds (1e-6, 5e-3, .97 to 1.03)")


STUDIES = {
    "cases": cases, "methods": methods, "blind": blind, "convergence": convergence, "sensitivity": sensitivity,
    "maps": maps, "paper-size": paper_size,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", nargs="+", choices=[*STUDIES, "reference"])
    parser.add_argument("--jobs", type=int, default=1, help="processes; the results do not depend on it")
    parser.add_argument("--check", action="store_true", help="reference: compare, write nothing")
    given = parser.parse_args()
    for directory in (BUILD / "loops", BUILD / "measured", RESULTS / "loops"):
        directory.mkdir(parents=True, exist_ok=True)
    for study in given.study:
        if study == "reference":
            reference(given.check)
        else:
            began, began_cpu = time.perf_counter(), time.process_time()
            STUDIES[study](given.jobs)
            grid, structure = model("paper" if study == "paper-size" else "study")
            note(study, processes=given.jobs, seconds=round(time.perf_counter() - began),
                 cpu_seconds_of_this_process=round(time.process_time() - began_cpu), geometry=vars(Geometry()),
                 nodes=len(grid.points), elements=len(grid.hexahedra), openings=len(structure.stiffness))


if __name__ == "__main__":
    main()
