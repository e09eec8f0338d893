"""Poses in projected or geocentric coordinates, which are made small by an offset.

UTM coordinates are up to 10⁷ m (EPSG 32601 to 32760). What draws a map counts in 32-bit numbers, whose steps are 8 mm
at 10⁵ m and 0.5 m at 5 · 10⁶ m, so poses that are farther than :data:`FAR_M` from the origin of their frame are mapped
with an offset, which a map's file adds again.
"""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float64Array

Offset = tuple[float, float]  #: x and y, metres

FAR_M = 1e5
FARTHEST_M = 1e8  #: beyond which a number is no coordinate: geocentric and projected ones are within 2.1e7 m
STEP_M = 100.0  #: of an offset, a multiple of any cell's side
NO_OFFSET: Offset = (0.0, 0.0)


def offset_of(poses: Float64Array) -> Offset:
    """Return the offset with which poses (n, 2 …), x and y first, are mapped; zeros where none of them is far."""
    if not len(poses) or float(np.abs(poses[:, :2]).max()) <= FAR_M:
        return NO_OFFSET
    x, y = (float(value) for value in np.rint(poses[0, :2] / STEP_M) * STEP_M)
    return (x, y)


def note_on_offset(whose: str, offset: Offset) -> str:
    """Return the sentence on an offset for the poses that are named."""
    x, y = offset
    return (
        f"{whose} are georeferenced: they are shown less {x:.0f} m in x and {y:.0f} m in y, which the origin in the "
        "map’s yaml has again."
    )
