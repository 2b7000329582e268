# SPDX-License-Identifier: MIT OR Apache-2.0
"""Structured hexahedral meshes of bodies that touch, and the pairs of nodes at which they do. Lengths in mm.

Every body is extruded from one plane mesh of quadrilaterals, so that the nodes of two bodies that touch lie on each
other: contact is between pairs of nodes, and nothing has to be searched or projected."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Plane:
    """Quadrilaterals in the x-y plane. `zone` names the part that each belongs to."""

    points: np.ndarray  # [node, 2]
    quads: np.ndarray  # [quad, 4], counter-clockwise
    zone: np.ndarray  # [quad] of str

    def quads_in(self, zones):
        return self.quads[np.isin(self.zone, zones)]


@dataclass
class Pair:
    """Two faces that may touch, node by node. The opening is that of `upper` from `lower`, positive along the normal."""

    name: str
    lower: np.ndarray  # [point] node numbers
    upper: np.ndarray
    area: np.ndarray  # [point] mm2
    frame: np.ndarray  # [point, 3, 3]: normal (from lower to upper) and two tangents, one per row
    faces: np.ndarray  # [quad, 4] numbers of the points, for pictures and for interface elements


@dataclass
class Mesh:
    """Hexahedra of all bodies; different bodies share no nodes."""

    points: np.ndarray  # [node, 3]
    hexahedra: np.ndarray  # [element, 8]: the lower face around, then the upper one, as in VTK
    body: np.ndarray  # [element] of str
    pairs: list

    def nodes(self, body, where):
        """Numbers of the nodes of a body for which where(x, y, z) holds."""
        numbers = np.unique(self.hexahedra[self.body == body])
        return numbers[where(*self.points[numbers].T)]


class Builder:
    """Collects bodies extruded from one plane mesh, and the pairs between them."""

    def __init__(self, plane):
        self.plane = plane
        self._number = {}  # (body, plane node, height) -> node
        self._points, self._hexahedra, self._body, self._pairs = [], [], [], []

    def _nodes(self, body, plane_nodes, z, new=False):
        def number(node):
            key = body, int(node), round(float(z), 9)
            if new and key not in self._number:
                self._number[key] = len(self._points)
                self._points.append((*self.plane.points[node], z))
            return self._number[key]

        return np.vectorize(number, otypes=[int])(plane_nodes)

    def extrude(self, body, zones, heights):
        """Adds to a body the part above the zones, one layer of elements between each two heights."""
        quads = self.plane.quads_in(zones)
        faces = [self._nodes(body, quads, z, new=True) for z in heights]
        for low, high in zip(faces, faces[1:]):
            self._hexahedra.append(np.hstack([low, high]))
            self._body += [body] * len(quads)

    def touch(self, name, lower, upper, zones, z, below=False):
        """Two bodies touch over the zones at the height z, `upper` above; or below, where displacements are prescribed
        on the body above. The frame is reversed then: openings stay those of the body above from the one below."""
        nodes, faces = np.unique(self.plane.quads_in(zones), return_inverse=True)
        lower, upper = (self._nodes(body, nodes, z) for body in (lower, upper))
        frame = np.tile([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]], (len(nodes), 1, 1)) * (-1 if below else 1)
        self._add_pair(name, lower, upper, frame, faces.reshape(-1, 4))

    def touch_around(self, name, lower, upper, circle, heights, lead):
        """Two bodies touch over a cylinder: `circle` numbers its plane nodes in order, `lower` is inside.

        `lead`: angle of the normal from the axis towards the radius, as on the flanks of a thread."""
        lower, upper = (np.array([self._nodes(body, circle, z) for z in heights]) for body in (lower, upper))
        numbers = np.arange(lower.size).reshape(lower.shape)
        after = np.roll(numbers, -1, axis=1)
        faces = np.stack([numbers[:-1], after[:-1], after[1:], numbers[1:]], axis=-1).reshape(-1, 4)
        radius = np.tile(self.plane.points[circle], (len(heights), 1))
        radius = np.pad(radius / np.linalg.norm(radius, axis=1)[:, None], ((0, 0), (0, 1)))
        normal = np.sin(lead) * radius + [0, 0, np.cos(lead)]
        around = np.cross([0, 0, 1.0], radius)
        frame = np.stack([normal, around, np.cross(normal, around)], axis=1)
        self._add_pair(name, lower.ravel(), upper.ravel(), frame, faces)

    def _add_pair(self, name, lower, upper, frame, faces):
        corners = np.array(self._points)[lower][faces]
        area = np.zeros(len(lower))
        for corner in range(4):
            # The nodal (Lobatto) rule: exact for the area of a plane quadrilateral, and what interface elements use.
            along = corners[:, (corner + 1) % 4] - corners[:, corner]
            across = corners[:, corner - 1] - corners[:, corner]
            np.add.at(area, faces[:, corner], np.linalg.norm(np.cross(along, across), axis=1) / 4)
        self._pairs.append(Pair(name, lower, upper, area, frame, faces))

    def mesh(self):
        return Mesh(np.array(self._points), np.vstack(self._hexahedra), np.array(self._body), self._pairs)


def rectangles(x, y, zone):
    """A plane of rectangles between the grid lines; zone(x, y) of the centre names the part."""
    numbers = np.arange(len(x) * len(y)).reshape(len(x), len(y))
    quads = np.stack([numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:]], axis=-1).reshape(-1, 4)
    points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return Plane(points, quads, np.array([zone(*centre) for centre in points[quads].mean(axis=1)]))


def bolted_plate(quarter, core, rings, square, tails):
    """A disc within rings within a square, and what the square continues as to the left and to the right.

    quarter -- elements along a quarter of the circles, and along a side of the square
    core    -- ("name", radius, elements from the inner square to the circle)
    rings   -- from inside out: ("name", outer radius, elements)
    square  -- ("name", half side, elements)
    tails   -- ("left", "right", length, elements)

    Returns the plane, and a function that gives the nodes of the circle with a given radius."""
    points, quads, zones = [], [], []

    def add(block, zone):
        """A block of points [i, j, 2], counter-clockwise; points met before are shared."""
        numbers = np.empty(block.shape[:2], int)
        for at in np.ndindex(numbers.shape):
            numbers[at] = len(points)
            points.append(block[at])
        quads.append(np.stack([numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:]], -1).reshape(-1, 4))
        zones.extend([zone] * len(quads[-1]))

    def blend(a, b, elements):
        part = np.linspace(0, 1, elements + 1)[:, None, None]
        return a + part * (b - a)

    angle = np.linspace(-np.pi / 4, np.pi / 4, quarter + 1)
    arc = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    side = np.stack([np.ones(quarter + 1), np.tan(angle)], axis=1)
    # The inner square bulges half-way to a circle: its corners would make flat elements otherwise.
    name, radius, elements = core
    bulged = 0.55 * radius * (0.5 * arc + 0.5 * side / np.sqrt(1.5))
    turns = [np.array([[c, -s], [s, c]]) for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    right, top, left, bottom = (bulged @ turn.T for turn in turns)
    u = (np.arange(quarter + 1) / quarter)[:, None, None]
    v = u.reshape(1, -1, 1)
    # Transfinite interpolation of the four sides.
    low, high, west, east = bottom[:, None], top[::-1][:, None], left[::-1][None], right[None]
    add((1 - v) * low + v * high + (1 - u) * west + u * east
        - ((1 - u) * (1 - v) * bottom[0] + u * (1 - v) * bottom[-1] + (1 - u) * v * top[-1] + u * v * top[0]), name)
    for turn in turns:
        inner = bulged
        for zone, outer_radius, count in [core, *rings]:
            add(blend(inner, outer_radius * arc, count) @ turn.T, zone)
            inner = outer_radius * arc
        zone, half, count = square
        add(blend(inner, half * side, count) @ turn.T, zone)
    name_left, name_right, length, elements = tails
    half = square[1]
    for name, start, end in ((name_left, -half - length, -half), (name_right, half, half + length)):
        x = np.linspace(start, end, elements + 1)
        add(np.stack(np.meshgrid(x, half * side[:, 1], indexing="ij"), axis=-1), name)

    points = np.array(points)
    _, first, numbers = np.unique(points.round(9), axis=0, return_index=True, return_inverse=True)
    plane = Plane(points[first], numbers.ravel()[np.vstack(quads)], np.array(zones))

    def circle(radius):
        nodes = np.flatnonzero(np.isclose(np.linalg.norm(plane.points, axis=1), radius, atol=1e-6))
        return nodes[np.argsort(np.arctan2(*plane.points[nodes].T[::-1]))]

    return plane, circle
