"""The axes of the map frame and a grid of lines on the floor. Every 3D view has these drawings, initially hidden."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from server.sessions.drawings import Drawing, Segments
from server.sessions.scene_controls import Bounds

AXES, GRID = "Axes", "Grid"
OFF_AT_FIRST = frozenset({AXES, GRID})  #: labels of drawings that are hidden until they are switched on
LEAST_CELLS = 8  #: least number of cells along the longer side of the bounds
LIFT = 0.01  #: height of the lines over the floor, in cells, so that the floor does not hide them
LINE = (128, 128, 128)  #: contrast on a light page equals that on a dark one
X, Y, Z = (214, 60, 50), (58, 150, 60), (50, 100, 214)


def spacing_of(bounds: Bounds) -> float:
    """Return the distance between two lines of the grid, metres: 1, 2 or 5 times a power of ten."""
    most = max(bounds[2] - bounds[0], bounds[3] - bounds[1], 0.1) / LEAST_CELLS
    power = math.floor(math.log10(most))
    return max(float(f"{step}e{power}") for step in (1, 2, 5) if step * 10.0**power <= most * (1.0 + 1e-9))


@lru_cache(maxsize=16)
def axes_and_grid(bounds: Bounds, floor: float) -> tuple[Drawing, Drawing]:
    """Return the axes at the origin of the map frame, and the grid that covers ``bounds`` at the height ``floor``.

    The lines are at multiples of their distance in x and y, metres. The length of the axes is twice this distance.
    """
    spacing = spacing_of(bounds)
    low = np.floor(np.array(bounds[:2]) / spacing)
    high = np.ceil(np.array(bounds[2:]) / spacing)
    (x0, y0), (x1, y1), z = low * spacing, high * spacing, floor + LIFT * spacing
    lines = [((x, y0, z), (x, y1, z)) for x in np.arange(low[0], high[0] + 1.0) * spacing]
    lines += [((x0, y, z), (x1, y, z)) for y in np.arange(low[1], high[1] + 1.0) * spacing]
    ends = np.zeros((3, 2, 3), np.float32)
    ends[:, 1] = 2.0 * spacing * np.eye(3)
    colors = np.repeat(np.array([X, Y, Z], np.uint8)[:, None], 2, axis=1)
    return (
        Segments(name="axes", label=AXES, points=ends, colors=colors, width=4.0),
        Segments(name="grid", label=GRID, points=np.array(lines, np.float32), colors=LINE),
    )
