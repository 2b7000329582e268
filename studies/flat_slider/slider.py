# SPDX-License-Identifier: MIT OR Apache-2.0
"""A cube of steel on a flat of steel: geometry, mesh, loads. Millimetres, newtons, megapascals.

The flat's lower face is fixed. Pressure acts on the slider's top; its right side is moved along x and else free."""

import numpy as np

from condense import Moved, Pressed, condense
from mesh import Builder, rectangles

FLAT = (80.0, 30.0, 10.0)
SIDE = 10.0  # of the slider, which stands in the middle of the flat
LEFT, RIGHT = (FLAT[0] - SIDE) / 2, (FLAT[0] + SIDE) / 2
FRONT, BACK = (FLAT[1] - SIDE) / 2, (FLAT[1] + SIDE) / 2
AREA = SIDE**2
YOUNG, POISSON = 200e3, 0.3


def graded(size, length, growth=1.6):
    """Distances from 0 to the length: elements begin with the size and grow by the factor."""
    count = max(1, round(np.log(1 + length / size * (growth - 1)) / np.log(growth)))
    distances = np.cumsum(growth ** np.arange(count))
    return np.concatenate([[0], distances / distances[-1] * length])


def build(along):
    """The mesh with `along` elements on each edge of the contact, coarser away from it."""
    size = SIDE / along

    def across(start, end):
        """Grid lines over the width of the flat: even under the slider, graded beyond it."""
        beyond = graded(size, start)[1:]
        return np.concatenate([(start - beyond)[::-1], np.linspace(start, end, along + 1), end + beyond])

    def zone(x, y):
        return "slider" if LEFT < x < RIGHT and FRONT < y < BACK else "flat"

    plane = rectangles(across(LEFT, RIGHT), across(FRONT, BACK), zone)
    build = Builder(plane)
    build.extrude("flat", ["flat", "slider"], -graded(size, FLAT[2], 1.5)[::-1])
    build.extrude("slider", ["slider"], graded(size, SIDE, 1.3))
    # The right side is moved down to its lower edge, so the slider must be the lower body of the pair.
    build.touch("contact", "slider", "flat", ["slider"], 0.0, below=True)
    return build.mesh()


def supports(mesh):
    """Nodes of the fixed lower face, of the moved right side, and nodal forces of a pressure of 1 MPa on the top."""
    fixed = mesh.nodes("flat", lambda x, y, z: np.isclose(z, -FLAT[2]))
    right = mesh.nodes("slider", lambda x, y, z: np.isclose(x, RIGHT))
    top = mesh.nodes("slider", lambda x, y, z: np.isclose(z, SIDE))

    def in_order(nodes):
        return np.lexsort(mesh.points[nodes, :2].round(6).T)

    # The top has the grid of the contact, hence its nodal areas.
    pair = mesh.pairs[0]
    forces = np.zeros_like(mesh.points)
    forces[top[in_order(top)], 2] = -pair.area[in_order(pair.lower)]
    return fixed, right, forces


def interface(mesh, young=YOUNG, progress=True):
    """The condensed structure. Load parameters: pressure on the top, displacement of the right side."""
    fixed, right, forces = supports(mesh)
    return condense(mesh, fixed, [Pressed(forces), Moved(right, 0)], young, POISSON, progress=progress)
