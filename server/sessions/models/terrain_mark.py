"""The patch of a terrain that is asked about, as a drawing in 3D."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mapper.core.errors import MapperError
from server.sessions.drawings import Segments
from server.sessions.models.chosen_voxel import CHOSEN
from server.sessions.models.terrain_patch import place_of

if TYPE_CHECKING:
    from server.sessions.models.lab_terrain import Assessed

_CORNERS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


def patch_mark(found: Assessed, x: float, y: float) -> Segments | None:
    """Return lines around the patch at (x, y), or the window that its plane is fitted to; None for a place outside.

    The lower four lie in the plane, the upper four above the highest ground point, where no voxel hides them. Without
    a plane the lower ones are at the lowest ground point, and without points at the lowest of the whole terrain.
    """
    try:
        row, col, centre, half = place_of(found, x, y)
    except MapperError:
        return None
    patches = found.terrain.patches
    inside = found.index.window(row, col, found.reach)
    z = found.ground_points[inside, 2] if len(inside) else patches.corner[2:]
    level, along_x, along_y = found.terrain.planes[row, col, :3].tolist()
    offsets = half * _CORNERS
    low = patches.corner[2] + level + offsets @ (along_x, along_y)
    low = np.where(np.isfinite(low), low, z.min())
    top = np.full(4, max(z.max(), low.max()) + patches.size)
    lower, upper = (np.column_stack([centre + offsets, heights]) for heights in (low, top))
    rings = [np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in (lower, upper)]
    lines = np.concatenate([*rings, np.stack([lower, upper], axis=1)])
    return Segments(
        name="asked-patch", label="Patch that is explained", points=lines.astype(np.float32), colors=CHOSEN, width=3.0
    )
