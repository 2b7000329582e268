"""Closed forms that the hosts are compared with. Nothing here calls the library."""

import numpy as np

from box import CRITICAL_SLIP, EXPONENT, FRICTION, HEIGHT, PRESSURE, SHEAR


def backbone(slip, exponent):
    """Traction over mu p at first loading, the standard penalty for an exponent of 1."""
    return 1 - (1 - np.minimum(slip / CRITICAL_SLIP, 1)) ** exponent


def series(displacement, exponent):
    """First loading of the law in series with the shear of both blocks: the traction at a displacement >= 0.

    The slip g solves displacement = g + traction(g) * 2 H/G; the right-hand side rises, so it is bisected.
    """
    limit = FRICTION * PRESSURE
    low, high = 0.0, displacement
    for _ in range(200):
        middle = (low + high) / 2
        if middle + limit * backbone(middle, exponent) * 2 * HEIGHT / SHEAR < displacement:
            low = middle
        else:
            high = middle
    return limit * backbone((low + high) / 2, exponent)


def masing(first_loading, path):
    """Masing's rules with memory: branches are the first loading, doubled, from where the motion turned.

    A series of springs and Coulomb elements keeps Masing's rules, so this holds for the law in the blocks.
    """
    turns = []  # (displacement, traction) of the open loops
    forces, last, sign = [0.0], path[0], 0
    for displacement in path[1:]:
        new = np.sign(displacement - last)
        if sign and new and new != sign:
            turns.append((last, forces[-1]))
        sign = new or sign
        # A loop that has been passed is forgotten together with the turn that opened it.
        while len(turns) > 1 and abs(displacement - turns[-1][0]) >= abs(turns[-2][0] - turns[-1][0]):
            del turns[-2:]
        if len(turns) == 1 and abs(displacement) >= abs(turns[0][0]) and sign * turns[0][0] < 0:
            turns = []
        if turns:
            start, force = turns[-1]
            forces.append(force + sign * 2 * first_loading(abs(displacement - start) / 2))
        else:
            forces.append(sign * first_loading(abs(displacement)))
        last = displacement
    return np.array(forces)


def sheared(path, method):
    """Traction of the sheared box."""
    return masing(lambda displacement: series(displacement, EXPONENT[method]), path)


def loop_area(displacement, force):
    """Area inside a closed loop, by trapezoids."""
    return abs(np.trapezoid(force, displacement))
