"""Offsets that reduce poses in projected or geocentric coordinates.

UTM coordinates are up to 10⁷ m (EPSG 32601 to 32760). Rendering uses 32-bit floats, whose resolution is 8 mm at 10⁵ m
and 0.5 m at 5 · 10⁶ m. So poses farther than :data:`FAR_M` from the origin of their frame are mapped with an offset,
which is added again in map files.
"""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float64Array

Offset = tuple[float, float]  #: x and y, metres

FAR_M = 1e5
FARTHEST_M = 1e8  #: larger numbers are not coordinates: geocentric and projected ones are within 2.1e7 m
STEP_M = 100.0  #: granularity of an offset, a multiple of any cell's side
NO_OFFSET: Offset = (0.0, 0.0)


def offset_of(poses: Float64Array) -> Offset:
    """Return the offset with which poses (n, 2 …), x and y first, are mapped; zeros if none of them is far."""
    if not len(poses) or float(np.abs(poses[:, :2]).max()) <= FAR_M:
        return NO_OFFSET
    x, y = (float(value) for value in np.rint(poses[0, :2] / STEP_M) * STEP_M)
    return (x, y)


def note_on_offset(whose: str, offset: Offset) -> str:
    """Return the note on an offset for the named poses."""
    x, y = offset
    return (
        f"{whose} are georeferenced: they are shown less {x:.0f} m in x and {y:.0f} m in y, which the origin in the "
        "map’s yaml has again."
    )
