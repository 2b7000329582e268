# SPDX-License-Identifier: MIT OR Apache-2.0
"""Pictures of the flat and slider: mesh, loops, maps of the contact, convergence."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as pyplot  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402
from matplotlib.colors import BoundaryNorm, ListedColormap  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402

import slider  # noqa: E402

STATUS = ("open", "stick", "micro-slip", "gross slip")  # the library's numbers 0 to 3
# After Okabe and Ito: also told apart by the colour-blind, and by their lightness.
STATUS_COLOURS = ("#999999", "#0072B2", "#F0E442", "#D55E00")
METHOD_STYLES = {"memory": ("#D55E00", "-"), "penalty": ("#0072B2", "--"), "Lagrange": ("#000000", ":")}


def save(figure, file, dpi=100):
    figure.savefig(file, dpi=dpi)
    pyplot.close(figure)


def mesh(file, mesh):
    """The three sides of each body that face the viewer, in parallel projection."""
    view = np.array([[0.90, 0.35, 0], [-0.16, 0.42, 0.95]])  # x, y, z on paper
    figure, axes = pyplot.subplots(figsize=(8, 4), layout="constrained")
    corners = np.array([[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
    for body, colour in (("flat", "#B8C4CC"), ("slider", "#E6B87D")):
        faces = mesh.hexahedra[mesh.body == body][:, corners].reshape(-1, 4)
        _, first, count = np.unique(np.sort(faces), axis=0, return_index=True, return_counts=True)
        outer = mesh.points[faces[first[count == 1]]]
        x, y, z = np.moveaxis(outer, -1, 0)
        ends = (x.max(), y.min(), z.max())
        seen = np.any([np.isclose(side, end).all(axis=1) for side, end in zip((x, y, z), ends)], axis=0)
        axes.add_collection(PolyCollection(outer[seen] @ view.T, facecolor=colour, edgecolor="#333333", linewidth=0.3))

    def arrow(start, end):
        axes.annotate("", view @ end, view @ start, arrowprops={"arrowstyle": "->"})

    def label(text, at, **more):
        axes.text(*(view @ at), text, **more)

    arrow([slider.RIGHT, 15, 5], [slider.RIGHT + 12, 15, 5])
    label("$A_0$ sin 2π$t$", [slider.RIGHT + 12.5, 15, 5], va="center")
    for x in (slider.LEFT + 1, 40, slider.RIGHT - 1):
        arrow([x, 15, 16], [x, 15, 10])
    label("pressure", [slider.RIGHT, 15, 14])
    label("lower face fixed", [40, 0, -13], ha="center")
    axes.set_aspect("equal")
    axes.autoscale()
    axes.margins(0.06)
    axes.axis("off")
    sizes = f"{len(mesh.points)} nodes, {len(mesh.hexahedra)} hexahedra, {len(mesh.pairs[0].area)} contact points"
    axes.set_title(sizes, fontsize="medium", pad=16)
    save(figure, file)


def loops(file, runs, limit, instants):
    """Friction force against relative displacement (the paper's Fig. 6), and against that of the right side."""
    figure, both = pyplot.subplots(1, 2, figsize=(10, 4.6), sharey=True, layout="constrained")
    for axes, column, label in zip(both, ("relative_displacement", "driven_displacement"),
                                   ("relative displacement of the contact", "displacement of the right side")):
        for method, run in runs.items():
            colour, line = METHOD_STYLES[method]
            axes.plot(1e3 * run.table[column], run.table["force"], line, color=colour, label=method, linewidth=1.5)
        for sign in (-1, 1):
            axes.axhline(sign * limit, color="grey", linewidth=0.6, zorder=0)
        table = runs["memory"].table
        for letter, instant in zip("abcdef", (0.0, *instants)):
            steps = np.flatnonzero(table["driven_displacement"] == instant)
            step = steps[0] if letter == "a" else steps[-1]
            point = 1e3 * table[column][step], table["force"][step]
            axes.plot(*point, "o", color=METHOD_STYLES["memory"][0], markersize=4)
            beside = (2, 6) if letter in "ef" else (11, -4)  # clear of the loops
            axes.annotate(letter, point, beside, textcoords="offset points", fontsize="small")
        axes.set(xlabel=f"{label} (µm)", xlim=(-11.5, 11.5))
        axes.grid(color="#EEEEEE", zorder=-1)
    both[0].set_ylabel("friction force on the contact (N)")
    both[0].text(-6, limit + 8, "mu N", color="grey", fontsize="small")
    figure.legend(*both[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    save(figure, file)


def maps(file, mesh, runs):
    """Contact status by method, and the pressure with the memory law, seen from above."""
    pair = mesh.pairs[0]
    x, y = mesh.points[pair.lower, :2].T
    lines = np.unique(x.round(6))
    count = len(lines)
    order = np.lexsort((x.round(6), y.round(6)))  # rows of constant y
    # Each point stands for its share of the area; the grid is the same along x and y.
    edges = np.concatenate([[0], (lines[1:] + lines[:-1]) / 2 - lines[0], [slider.SIDE]])
    looks = runs["memory"].looks
    top = np.quantile(np.concatenate([pressure for _, _, pressure in looks]), 0.995)
    figure, cells = pyplot.subplots(
        len(runs) + 1, len(looks), figsize=(1.75 * len(looks), 6.8), sharex=True, sharey=True, layout="constrained")
    colours, norm = ListedColormap(STATUS_COLOURS), BoundaryNorm(np.arange(5) - 0.5, 4)

    def draw(axes, values, **more):
        image = axes.pcolormesh(edges, edges, values[order].reshape(count, count), rasterized=True, **more)
        axes.set_aspect("equal")
        return image

    for line, (method, run) in zip(cells, runs.items()):
        for axes, (_, status, _) in zip(line, run.looks):
            draw(axes, status, cmap=colours, norm=norm)
        line[0].set_ylabel(f"{method}\ny (mm)")
    for axes, (_, _, pressure) in zip(cells[-1], looks):
        image = draw(axes, pressure, cmap="viridis", vmin=0, vmax=top)
        axes.set_xlabel("x (mm)")
    cells[-1, 0].set_ylabel("memory\ny (mm)")
    figure.colorbar(image, ax=cells[-1], label="pressure (MPa)", extend="max")
    for letter, axes, (label, _, _) in zip("abcdef", cells[0], looks):
        axes.set_title(f"({letter}) {label}", fontsize="medium")
    figure.legend(handles=[Patch(color=colour, label=name) for colour, name in zip(STATUS_COLOURS[1:], STATUS[1:])],
                  loc="outside upper center", ncols=3)
    save(figure, file, 90)


def convergence(file, meshes, runs):
    """How the figures of the loop change with the mesh, and the pressure along the middle of the contact."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10, 4), layout="constrained")
    along = sorted(meshes)
    finest = along[-1]  # what the others are compared with
    sizes = slider.SIDE / np.array(along)
    for method, (colour, line) in METHOD_STYLES.items():
        for name, mark in (("dissipation", "o"), ("driven_stick_slope", "^")):
            values = np.array([runs[method, number].figures[name] for number in along])
            left.loglog(sizes[:-1], 100 * np.abs(values[:-1] / values[-1] - 1), line, marker=mark, color=colour,
                        markerfacecolor="none", label=f"{method}: {name.replace('_', ' ')}")
    left.set(xlabel="element size in the contact (mm)", ylabel=f"difference from {finest} x {finest} (%)",
             xticks=sizes[:-1], xticklabels=[f"{size:g}" for size in sizes[:-1]], ylim=(0.05, 200))
    left.minorticks_off()
    left.legend(fontsize="small", ncols=2)
    for number, colour in zip(along, ("#56B4E9", "#E69F00", "#000000")):
        pair = meshes[number].pairs[0]
        x, y = meshes[number].points[pair.lower, :2].T
        # The line of nodes next to the middle (an odd number of elements has none there).
        middle = np.isclose(y, y[np.abs(y - slider.FLAT[1] / 2).argmin()])
        step = np.argsort(x[middle])
        _, _, pressure = runs["memory", number].looks[-1]
        right.plot(x[middle][step] - slider.LEFT, pressure[middle][step], ".-", color=colour,
                   label=f"{number} x {number}")
    right.set(xlabel="x from the slider's left edge (mm)", ylabel="pressure (MPa)",
              title="memory, gross slip to the left (f), middle of the contact")
    right.title.set_fontsize("medium")
    right.legend()
    save(figure, file)
