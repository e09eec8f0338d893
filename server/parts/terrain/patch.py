"""The queried patch of a terrain: points, moments, neighbours, children, and a mark in 3D."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError, MapperError
from mapper.core.sampling import sample_rows
from mapper.terrain.patches import UNSAFE
from server.parts.terrain.messages import TerrainPatch
from server.sessions.drawings import CHOSEN, Segments

if TYPE_CHECKING:
    from server.parts.terrain.assessment import Assessed

_CORNERS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
MOST_SENT = 400  #: points of a patch; more are sampled


def first_asked(assessment: Assessed) -> tuple[float, float] | None:
    """Return the centre of the unsafe patch with a plane that is nearest to the centre of all; None if none."""
    terrain = assessment.terrain
    unsafe = np.argwhere((terrain.classes == UNSAFE) & np.isfinite(terrain.score))
    if not len(unsafe):
        return None
    away = np.square(unsafe - 0.5 * (np.array(terrain.classes.shape) - 1)).sum(axis=1)
    row, col = unsafe[np.argmin(away)].tolist()
    x, y = terrain.geometry.cell_to_world((row, col))
    return float(x), float(y)


def place_of(assessment: Assessed, x: float, y: float) -> tuple[int, int, Float64Array, float]:
    """Return row and column of the patch at (x, y), its centre (2,), and half the side of the plane's area.

    The plane is fitted to the patch or to a window around it. Raises :class:`ConfigError` for a place outside.
    """
    patches = assessment.terrain.patches
    row, col = (int(k) for k in patches.geometry.world_to_cell((x, y)))
    rows, cols = assessment.terrain.classes.shape
    if not (0 <= row < rows and 0 <= col < cols):
        raise ConfigError("terrain.outside", f"The place ({x:g}, {y:g}) lies outside of the patches.")
    centre = np.asarray(patches.geometry.cell_to_world((row, col)), dtype=np.float64)
    return row, col, centre, (assessment.reach + 0.5) * patches.size


def patch_at(assessment: Assessed, x: float, y: float) -> TerrainPatch:
    """Return the message's fields about the patch at (x, y), or the window around it to which its plane is fitted.

    Raises :class:`ConfigError` for a place outside.
    """
    patches, terrain = assessment.terrain.patches, assessment.terrain
    row, col, (cx, cy), half = place_of(assessment, x, y)
    inside = assessment.index.window(row, col, assessment.reach)
    local = assessment.ground_points[inside] - patches.corner
    # Heights are relative to the whole metre nearest to the lowest point, so that changes of P keep their precision.
    base = float(np.round(local[:, 2].min())) if len(inside) else 0.0
    mine = local - (*((np.array([col, row]) + 0.5) * patches.size), base)
    used = mine[assessment.is_fitted[inside]]
    sent = mine[sample_rows(len(mine), MOST_SENT)]
    return TerrainPatch(
        x=round(x, 4),
        y=round(y, 4),
        centre=(round(float(cx), 4), round(float(cy), 4)),
        half=half,
        base=float(patches.corner[2]) + base,
        moments=_moments(used),
        n=len(mine),
        points=[round(v, 4) for v in sent.ravel().tolist()],
        edges=[round(v, 4) for v in _edges(terrain.planes, row, col, patches.size, base)],
        children=_children(used) if assessment.level and not assessment.reach else [],
        why=terrain.why(row, col),
        state=("unknown", "safe", "unsafe")[int(terrain.classes[row, col])],
    )


def _moments(points: Float64Array) -> list[float]:
    """Return P (4, 4) of points (n, 3), row by row."""
    p = np.column_stack([np.ones(len(points)), points])
    return [round(v, 6) for v in (p.T @ p).ravel().tolist()]


def _children(points: Float64Array) -> list[list[float]]:
    """Return P of each of the four children of a patch, about the centre of the patch. Their sum is its P."""
    quarter = (points[:, 0] >= 0.0) + 2 * (points[:, 1] >= 0.0)
    return [_moments(points[quarter == k]) for k in range(4)]


def _edges(planes: Float64Array, row: int, col: int, size: float, base: float) -> list[float]:
    """Return x, y and height above ``base`` of the neighbours' planes at the middle of the common edges."""
    edges = []
    for down, right in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        r, c = row + down, col + right
        if 0 <= r < planes.shape[0] and 0 <= c < planes.shape[1] and not math.isnan(planes[r, c, 0]):
            a, b, slope_y = (float(v) for v in planes[r, c, :3])
            x, y = 0.5 * size * right, 0.5 * size * down
            edges += [x, y, a - b * x - slope_y * y - base]
    return edges


def patch_mark(assessment: Assessed, x: float, y: float) -> Segments | None:
    """Return lines around the patch at (x, y), or its plane's window; None for a place outside.

    The lower four lines are in the plane, the upper four above the highest ground point, where no voxel hides them.
    Without a plane the lower ones are at the lowest ground point, and without points at the lowest of the whole
    terrain.
    """
    try:
        row, col, centre, half = place_of(assessment, x, y)
    except MapperError:
        return None
    patches = assessment.terrain.patches
    inside = assessment.index.window(row, col, assessment.reach)
    z = assessment.ground_points[inside, 2] if len(inside) else patches.corner[2:]
    level, along_x, along_y = assessment.terrain.planes[row, col, :3].tolist()
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
