"""Which beams a polished wall reflects away."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mapper.core.jit import jit


@jit
def reflect(
    faces: NDArray[np.float64],
    ranges: NDArray[np.float64],
    bearings: NDArray[np.float64],
    x: float,
    y: float,
    most_sine: float,
    on_wall: float,
    out: NDArray[np.bool_],
) -> None:
    """Write into ``out`` (n,) whether beam i ends on a polished face that it meets at a slant.

    ``faces`` (m, 4) are segments of positive length, ``(ax, ay, bx, by)`` in metres; ``ranges`` (n,) metres, not finite
    for no return; ``bearings`` (n,) radians in the frame of the faces, in which (x, y) is the sensor. A beam slants if
    the sine of its angle to the face's normal exceeds ``most_sine``; it ends on a face if its end is no farther from
    the face than ``on_wall`` metres.
    """
    n_faces = faces.shape[0]
    units, lengths = np.empty((n_faces, 2)), np.empty(n_faces)
    for k in range(n_faces):
        ex, ey = faces[k, 2] - faces[k, 0], faces[k, 3] - faces[k, 1]
        lengths[k] = math.hypot(ex, ey)
        units[k, 0], units[k, 1] = ex / lengths[k], ey / lengths[k]
    for i in range(out.shape[0]):
        out[i] = False
        if not math.isfinite(ranges[i]):
            continue
        dx, dy = math.cos(bearings[i]), math.sin(bearings[i])
        end_x, end_y = x + ranges[i] * dx, y + ranges[i] * dy
        for k in range(n_faces):
            ux, uy = units[k, 0], units[k, 1]
            # The sine of the angle between beam and normal is the cosine of that between beam and face.
            if abs(dx * ux + dy * uy) <= most_sine:
                continue
            ox, oy = end_x - faces[k, 0], end_y - faces[k, 1]
            along = ox * ux + oy * uy
            if abs(ox * uy - oy * ux) <= on_wall and -on_wall <= along <= lengths[k] + on_wall:
                out[i] = True
                break
