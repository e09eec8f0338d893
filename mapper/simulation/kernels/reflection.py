"""Beams that a polished wall reflects away."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mapper.core.jit import jit


@jit
def reflect(
    faces: NDArray[np.float64],
    ranges: NDArray[np.float64],
    beams: NDArray[np.float64],
    sensor: tuple[float, float, float, float],
    most_sine: float,
    on_wall: float,
    out: NDArray[np.bool_],
) -> None:
    """Write into ``out`` (n,) whether beam i ends on a polished face that it hits obliquely.

    ``faces`` (m, 4) are segments of positive length, ``(ax, ay, bx, by)`` in metres; ``ranges`` (n,) metres, not finite
    for no return; ``beams`` (n, 2) cosine and sine of the bearings in the sensor's frame, which is at ``sensor`` (x, y,
    cos θ, sin θ) in that of the faces. A beam is oblique if the sine of its angle to the face's normal exceeds
    ``most_sine``; it ends on a face if its end is within ``on_wall`` metres of the face.
    """
    n = out.shape[0]
    x, y, cos, sin = sensor
    directions, ends = np.empty((2, n)), np.empty((2, n))
    for i in range(n):
        out[i] = False
        directions[0, i] = cos * beams[i, 0] - sin * beams[i, 1]
        directions[1, i] = sin * beams[i, 0] + cos * beams[i, 1]
        # A beam without return has no finite end, so every comparison with it is false.
        reach = ranges[i] if math.isfinite(ranges[i]) else math.nan
        ends[0, i], ends[1, i] = x + reach * directions[0, i], y + reach * directions[1, i]
    dx, dy, end_x, end_y = directions[0], directions[1], ends[0], ends[1]
    for k in range(faces.shape[0]):
        ax, ay = faces[k, 0], faces[k, 1]
        ex, ey = faces[k, 2] - ax, faces[k, 3] - ay
        length = math.hypot(ex, ey)
        ux, uy = ex / length, ey / length
        # Without branches, so that it is vectorised.
        for i in range(n):
            ox, oy = end_x[i] - ax, end_y[i] - ay
            along = ox * ux + oy * uy
            # The sine of the angle between beam and normal is the cosine of that between beam and face.
            slants = abs(dx[i] * ux + dy[i] * uy) > most_sine
            out[i] |= slants & (abs(ox * uy - oy * ux) <= on_wall) & (along >= -on_wall) & (along <= length + on_wall)
