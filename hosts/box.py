"""The friction box that every host runs: two elastic blocks, one on the other, and the law between them.

Units mm, N, MPa; the last coordinate is the normal. Two load cases:

- sheared: every node of a block keeps its height, so the pressure is the same everywhere and the shear is uniform.
  This has a closed form: the law in series with the elastic shear of the blocks (reference.py).
- pressed: the lower block is wider and only the outer faces are held, so the pressure is uneven and slip starts
  where it is low. The plateau is mu N all the same, by equilibrium.

Both are pressed together first; then the top face goes to and fro.
"""

from dataclasses import dataclass, field
from itertools import product

import numpy as np

YOUNG, POISSON = 200e3, 0.3
SHEAR = YOUNG / (2 * (1 + POISSON))
LENGTH, HEIGHT = 10.0, 5.0  # of the upper block
FRICTION, CRITICAL_SLIP = 0.3, 2e-3
# The law is the same in both: an exponent of 1 is the standard penalty method.
EXPONENT = {"memory": 2.5, "penalty": 1.0}
NORMAL_STIFFNESS = 1e5
PRESSURE = 50.0  # exact in the sheared box, about the mean in the pressed one
AMPLITUDE = 4 * CRITICAL_SLIP
# Turning points over AMPLITUDE: one full cycle, a loop inside it, and past that loop.
TURNS = (0.0, 1.0, -1.0, 1.0, 0.1, 0.6, -1.0)
CYCLE = (1, 3)  # the turning points that the full cycle lies between


@dataclass
class Box:
    """A structured mesh. `layer`: thickness of the contact's elements, 0 for interface elements."""

    case: str  # "sheared" or "pressed"
    divisions: tuple  # elements of the upper block: (along, high) or (along, across, high)
    layer: float = 0.0
    nodes: np.ndarray = field(init=False)  # coordinates
    blocks: np.ndarray = field(init=False)  # connectivity of the blocks
    contact: np.ndarray = field(init=False)  # connectivity of the contact: face of the lower block, of the upper
    lower: np.ndarray = field(init=False)  # nodes of the lower block
    upper: np.ndarray = field(init=False)
    bottom: np.ndarray = field(init=False)  # nodes of the face that is held
    top: np.ndarray = field(init=False)  # nodes of the face that is moved

    def __post_init__(self):
        *along, high = self.divisions
        sizes = [LENGTH / n for n in along]
        margin = [0 if self.case == "sheared" else max(1, n // 4) for n in along]
        wide = [n + 2 * m for n, m in zip(along, margin)]
        start = [-m * size for m, size in zip(margin, sizes)]
        low_nodes, low = grid((*wide, high), (*sizes, HEIGHT / high), (*start, 0.0))
        up_nodes, up = grid(
            (*along, high), (*sizes, HEIGHT / high), (*(0.0 for _ in along), HEIGHT + self.layer)
        )
        up += low.size
        shared = tuple(slice(m, m + n + 1) for m, n in zip(margin, along))
        self.nodes = np.vstack([low_nodes, up_nodes])
        self.blocks = np.vstack([solid(numbers) for numbers in (low, up)])
        self.contact = np.hstack([face(low[..., -1][shared]), face(up[..., 0])])
        self.lower, self.upper = low.ravel(), up.ravel()
        self.bottom, self.top = low[..., 0].ravel(), up[..., -1].ravel()

    @property
    def dim(self):
        return len(self.divisions)

    @property
    def name(self):
        return f"{self.dim}d_{self.case}"

    @property
    def area(self):
        """Area of the contact; in two dimensions for a depth of 1."""
        return LENGTH ** (self.dim - 1)

    @property
    def direction(self):
        """Direction of the motion: oblique to the mesh where there are two to choose from."""
        return np.array([1.0] if self.dim == 2 else [0.8, 0.6])

    @property
    def closing(self):
        """How far the top face goes down."""
        closing = PRESSURE / NORMAL_STIFFNESS
        if self.case == "pressed":
            closing += 2 * HEIGHT * PRESSURE / YOUNG
        return closing


def grid(divisions, sizes, start):
    """Nodes of a block, and their numbers by position."""
    axes = [s + size * np.arange(n + 1) for n, size, s in zip(divisions, sizes, start)]
    nodes = np.array(list(product(*axes)))
    return nodes, np.arange(len(nodes)).reshape([n + 1 for n in divisions])


def face(numbers):
    """Cells of one layer of nodes: a line's segments, or a plane's quadrilaterals (around each)."""
    if numbers.ndim == 1:
        corners = [numbers[:-1], numbers[1:]]
    else:
        corners = [numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:]]
    return np.stack([corner.ravel() for corner in corners], axis=-1)


def solid(numbers):
    """Cells of a block: quadrilaterals (around each) or hexahedra (lower face, upper face)."""
    layers = [face(numbers[..., k]) for k in range(numbers.shape[-1])]
    if numbers.ndim == 2:
        return np.vstack([np.hstack([a, b[:, ::-1]]) for a, b in zip(layers, layers[1:])])
    return np.vstack([np.hstack([a, b]) for a, b in zip(layers, layers[1:])])


def history(steps):
    """Displacement of the top face along its direction, so many steps from turn to turn; the first is the start."""
    branches = [np.linspace(a, b, steps + 1)[1:] for a, b in zip(TURNS, TURNS[1:])]
    return AMPLITUDE * np.concatenate([TURNS[:1], *branches])


def cycle(steps):
    """The rows of a history that make up the full cycle."""
    return slice(CYCLE[0] * steps, CYCLE[1] * steps + 1)
