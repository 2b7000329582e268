# SPDX-License-Identifier: MIT OR Apache-2.0
"""The bolted lap joint: geometry, mesh, its two ends. Millimetres. Needs nothing but numpy, so that any host can use it.

Two plates of 20 mm width overlap by 20 mm; an M6 bolt presses them together, with a force washer under its head. The
fixed plate is the upper one. The plates' free length sets the series stiffness, and the grip (force washer) together
with the shank sets the residual stiffness: these two are calibrated at one state (900 N, mu .3, amplitude .02 mm), the
paper does not give them."""

from dataclasses import dataclass

import numpy as np

from mesh import Builder, bolted_plate

YOUNG, POISSON = 200e3, 0.3


@dataclass
class Geometry:
    plate: float = 5.0  # thickness
    half: float = 10.0  # half the overlap, half the width
    free: float = 33.0  # of each plate beyond the overlap
    hole: float = 3.5  # radii
    shank: float = 2.53  # of the stress cross-section
    head: float = 5.0  # also of the nut
    washer: float = 7.25
    washer_height: float = 14.08
    head_height: float = 4.0
    nut_height: float = 5.0
    thread_contact: bool = False  # the thread as a contact pair, not bonded
    flank: float = np.pi / 6  # normal of its flanks from the axis


@dataclass
class Density:
    """Numbers of elements. The names of the zones are those of the radii they reach to."""

    quarter: int = 6
    core: int = 2
    clearance: int = 1  # shank to hole
    head: int = 2  # hole to head
    washer: int = 2  # head to washer
    square: int = 3
    free: int = 7
    plate: int = 4  # through the thickness
    washer_height: int = 4
    head_height: int = 3
    nut_height: int = 3

    def finer(self, factor):
        """About `factor` times as many along every edge."""
        return Density(**{name: max(1, round(count * factor)) for name, count in vars(self).items()})


MESHES = {
    "smallest": Density(3, 1, 1, 1, 1, 2, 4, 2, 2, 1, 1),
    "coarse": Density(4, 1, 1, 1, 1, 2, 5, 3, 3, 2, 2),
    "study": Density(),
    "fine": Density().finer(1.5),
    # Fine where the solids bend; the number of contact points decides the time.
    "paper": Density(12, 5, 3, 4, 4, 6, 52, 22, 40, 12, 18),
}


def build(geometry=Geometry(), density=Density()):
    """The mesh of the joint, its contact pairs from top to bottom."""
    g, d = geometry, density
    rings = [("clearance", g.hole, d.clearance), ("head", g.head, d.head), ("washer", g.washer, d.washer)]
    plane, circle = bolted_plate(
        d.quarter, ("shank", g.shank, d.core), rings, ("square", g.half, d.square), ("left", "right", g.free, d.free))

    def heights(start, end, count):
        return np.linspace(start, end, count + 1)

    top = g.plate + g.washer_height  # of the washer
    fixed, moving = heights(0, g.plate, d.plate), heights(-g.plate, 0, d.plate)
    washer, head = heights(g.plate, top, d.washer_height), heights(top, top + g.head_height, d.head_height)
    nut = heights(-g.plate - g.nut_height, -g.plate, d.nut_height)
    disc = ["shank", "clearance", "head"]
    overlap = ["head", "washer", "square"]

    build = Builder(plane)
    build.extrude("fixed", ["left", *overlap], fixed)
    build.extrude("moving", [*overlap, "right"], moving)
    build.extrude("washer", ["head", "washer"], washer)
    build.extrude("bolt", disc, head)
    build.extrude("bolt", ["shank"], np.unique(np.concatenate([nut, moving, fixed, washer])))
    nut_body = "nut" if g.thread_contact else "bolt"
    build.extrude(nut_body, ["clearance", "head"], nut)

    build.touch("head-washer", "washer", "bolt", ["head"], top)
    build.touch("washer-plate", "fixed", "washer", ["head", "washer"], g.plate)
    build.touch("plate-plate", "moving", "fixed", overlap, 0.0)
    build.touch("plate-nut", nut_body, "moving", ["head"], -g.plate)
    if g.thread_contact:
        build.touch_around("thread", "bolt", "nut", circle(g.shank), nut, g.flank)
    return build.mesh()


def supports(mesh, geometry=Geometry()):
    """Nodes of the end that is held and of the end that is moved."""
    end = geometry.half + geometry.free
    held = mesh.nodes("fixed", lambda x, y, z: np.isclose(x, -end))
    moved = mesh.nodes("moving", lambda x, y, z: np.isclose(x, end))
    return held, moved
