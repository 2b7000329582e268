# SPDX-License-Identifier: MIT OR Apache-2.0
"""Four things to see: a loop with inner loops, a circle, a loop under a pulsing pressure, damping against amplitude.

    python gallery.py [DIRECTORY]     prints the numbers; with matplotlib it draws DIRECTORY/*.svg, too
"""

import sys
from pathlib import Path

import numpy as np

from mepc import Law

MU, GCR, PRESSURE = 0.3, 0.002, 100.0  # -, mm, MPa: gcr holds at this pressure
LIMIT = MU * PRESSURE


def path(*corners, steps=50):
    """From 0 to each corner in `steps` equal increments: positions, the start left out."""
    ends = np.concatenate([[0.0], corners])
    return np.concatenate([np.linspace(a, b, steps + 1)[1:] for a, b in zip(ends, ends[1:])])


def loop():
    """A loop of 1.5 gcr with a small loop inside each branch: the small ones close and leave no trace."""
    law = Law(mu=MU, gcr=GCR, reference_pressure=PRESSURE, ndir=1)
    slip = GCR * path(1.5, 0.2, 0.7, -1.5, -0.2, -0.7, 1.5)
    done = law.history(np.diff(slip, prepend=0), PRESSURE)
    return slip, done.traction


def circle():
    """Two turns of half gcr: the traction runs ahead of the slip, and its path is a circle after the first turn."""
    law = Law(mu=MU, gcr=GCR, reference_pressure=PRESSURE, ndir=2)
    angle = np.linspace(0, 4 * np.pi, 401)
    turns = 0.5 * GCR * np.column_stack([np.cos(angle), np.sin(angle)])
    slip = np.concatenate([np.column_stack([0.5 * GCR * path(1.0, steps=20), np.zeros(20)]), turns[1:]])
    done = law.history(np.diff(slip, axis=0, prepend=np.zeros((1, 2))), PRESSURE)
    return slip, done.traction, done.energy[-200:, 1].sum()


def ripple():
    """To and fro by .2 gcr about .5 gcr, under a pressure that is 40 % lower on the way forth and higher on the way back.
    The last of three cycles under both rules, and its dissipation over mu p gcr: under the proportional rule, which scales
    tractions with the pressure, it is negative, energy from nothing."""
    phase = np.linspace(0, 6 * np.pi, 601)[1:]
    slip = GCR * np.concatenate([path(0.5), 0.5 + 0.2 * np.sin(phase)])
    pressure = PRESSURE * np.concatenate([np.linspace(1, 0.6, 50), 1 - 0.4 * np.cos(phase)])
    loops = {}
    for rule, reference in (("consistent", PRESSURE), ("proportional", 0.0)):
        # A pressure that never rests needs more knots than the default state has: 64.
        law = Law(mu=MU, gcr=GCR, reference_pressure=reference, ndir=1, nstate=12 + 64 * 2)
        done = law.history(np.diff(slip, prepend=0), pressure)
        loops[rule] = done.traction, done.energy[-200:, 1].sum() / (LIMIT * GCR)
    return slip, loops


def damping():
    """Dissipation of a steady cycle against amplitude, 40 points in one call, beside the closed form 4 (2 F - a f).
    Small cycles: the cube of the amplitude, not the square of a viscous damper."""
    law = Law(mu=MU, gcr=GCR, reference_pressure=PRESSURE, ndir=1)
    amplitude = np.geomspace(0.02, 1.0, 40)  # over gcr
    slip = GCR * amplitude[:, None] * path(1.0, -1.0, 1.0)
    done = law.history(np.diff(slip, axis=1, prepend=0), PRESSURE)
    dissipated = done.energy[:, 50:, 1].sum(axis=1) / (LIMIT * GCR)
    f = 1 - (1 - amplitude) ** 2.5
    integral = amplitude - (1 - (1 - amplitude) ** 3.5) / 3.5
    return amplitude, dissipated, 4 * (2 * integral - amplitude * f)


def draw(folder):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as pyplot

    matplotlib.rcParams["svg.hashsalt"] = "mepc"

    def picture(name, xlabel, ylabel, equal=False):
        figure, axes = pyplot.subplots(figsize=(5.2, 3.9), layout="constrained")
        axes.set(xlabel=xlabel, ylabel=ylabel)
        if equal:
            axes.set_aspect("equal")

        def save():
            figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
            pyplot.close(figure)

        return axes, save

    axes, save = picture("loop", "slip (µm)", "traction (MPa)")
    axes.axhline(0, color="0.8", linewidth=0.8, zorder=0)
    slip, traction = loop()
    axes.plot(1e3 * slip, traction)
    save()

    axes, save = picture("circle", "first direction, over gcr and mu p", "second direction", equal=True)
    slip, traction, _ = circle()
    axes.plot(*(slip / GCR).T, label="slip")
    axes.plot(*(traction / LIMIT).T, label="traction")
    axes.legend(loc=(0.36, 0.3))
    save()

    axes, save = picture("ripple", "slip (µm)", "traction (MPa)")
    slip, loops = ripple()
    for rule, (traction, dissipated) in loops.items():
        axes.plot(1e3 * slip[-201:], traction[-201:], label=f"{rule}: {dissipated:+.3f} mu p gcr a cycle")
    axes.legend(loc="upper left")
    save()

    axes, save = picture("damping", "amplitude / gcr", "dissipation of a cycle / (mu p gcr)")
    amplitude, dissipated, exact = damping()
    axes.loglog(amplitude, exact, label="4 (2 F - a f)")
    axes.loglog(amplitude, dissipated, "o", markersize=3, label="library")
    axes.loglog(amplitude, dissipated[0] * (amplitude / amplitude[0]) ** 2, ":", color="0.5", label="viscous: square")
    axes.legend()
    save()


def main():
    slip, traction = loop()
    print(f"loop: {traction.max():.3f} MPa at most, limit {LIMIT:g}")
    print(f"circle: {circle()[2] / (LIMIT * GCR):.4f} mu p gcr dissipated in the last turn")
    for rule, (_, dissipated) in ripple()[1].items():
        print(f"ripple, {rule} rule: {dissipated:+.4f} mu p gcr in the last cycle")
    amplitude, dissipated, exact = damping()
    print(f"damping: {np.abs(dissipated / exact - 1).max():.1e} off the closed form at most")
    if len(sys.argv) > 1:
        folder = Path(sys.argv[1])
        folder.mkdir(parents=True, exist_ok=True)
        draw(folder)


if __name__ == "__main__":
    main()
