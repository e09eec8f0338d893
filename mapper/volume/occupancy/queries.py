"""Queries of a map: ray casts, nearest obstacle, voxels of a box, and views from above."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from mapper.core.array_types import Float32Array, Float64Array, Int64Array, UInt8Array
from mapper.core.errors import ConfigError
from mapper.core.parallel import cores, in_parallel, shares
from mapper.grid.occupancy_grid import GridGeometry, OccupancyGrid
from mapper.volume.blocks import BLOCK, KEYS
from mapper.volume.kernels.casts import HIT, OUTSIDE, TOO_FAR, UNKNOWN, cast_rays
from mapper.volume.kernels.queries import nearest_occupied, project_columns
from mapper.volume.kernels.rays import CENTRE
from mapper.volume.kernels.types import CastRule
from mapper.volume.occupancy.volume import OccupancyVolume

__all__ = ["HIT", "OUTSIDE", "TOO_FAR", "UNKNOWN", "Casts", "cast", "distance_to_obstacle", "project", "voxels_in_box"]

_ALL_OF_A_ROW = np.uint64(0x0101010101010101)  # eight true bytes
_SHARE = 1024  # rays or points above which a second thread is worthwhile


@dataclass(frozen=True, slots=True)
class Casts:
    """Ends of rays: the ``keys`` (n, 3) of their last voxels, the centres ``points`` (n, 3) in metres, and the reason.

    ``ends`` (n,) are :data:`HIT` (an occupied voxel), :data:`UNKNOWN`, :data:`TOO_FAR` or :data:`OUTSIDE` (the
    lattice).
    """

    keys: Int64Array
    points: Float32Array
    ends: UInt8Array


def cast(
    volume: OccupancyVolume, origins: ArrayLike, directions: ArrayLike, *, through_unknown: bool = True,
    range_max: float = 0.0,
) -> Casts:  # fmt: skip
    """Cast rays from ``origins`` (n, 3) or (3,), metres, along ``directions`` (n, 3) of any length.

    Unless ``through_unknown``, a ray ends at the first unknown voxel. A ``range_max`` of 0 means no limit; ranges are
    measured to voxel centres. Source: octomap's castRay. Raises :class:`ConfigError` for values that are not finite and
    directions whose length is 0 or not within float32.
    """
    away = np.ascontiguousarray(np.atleast_2d(directions), dtype=np.float32)
    start = np.ascontiguousarray(np.broadcast_to(np.asarray(origins, dtype=np.float32), away.shape))
    if away.shape[1:] != (3,) or not (np.isfinite(away).all() and np.isfinite(start).all()):
        raise ConfigError("volume.rays", "Rays must have finite origins and directions of three numbers.")
    with np.errstate(over="ignore", under="ignore"):
        squared = away[:, 0] * away[:, 0] + away[:, 1] * away[:, 1] + away[:, 2] * away[:, 2]
    if not ((squared > 0.0) & (squared < np.inf)).all():
        raise ConfigError("volume.rays", "A ray needs a direction whose length is not 0, from 1e-18 to 1e18.")
    if not (math.isfinite(range_max) and range_max >= 0.0):
        raise ConfigError("volume.rays", f"The longest range must be at least 0 m, not {range_max}.")
    config, n = volume.config, len(away)
    rule = CastRule(config.resolution, float(config.log_odds_occupied), through_unknown, float(range_max))
    keys, points, ends = np.empty((n, 3), dtype=np.int64), np.empty_like(away), np.empty(n, dtype=np.uint8)
    belief, masks = volume.belief, volume.stop_masks()
    in_parallel(
        [
            partial(cast_rays, belief, masks, start[a:b], away[a:b], rule, keys[a:b], points[a:b], ends[a:b])
            for a, b in shares(n, min(cores(), 1 + n // _SHARE))
        ]
    )
    return Casts(keys, points, ends)


def distance_to_obstacle(volume: OccupancyVolume, points: ArrayLike, distance_max: float) -> Float64Array:
    """Return the distance (n,), metres, from points (n, 3) to the nearest centre of an occupied voxel.

    It is infinite if there is none within ``distance_max`` metres. Raises :class:`ConfigError` for values that are not
    finite.
    """
    places = np.atleast_2d(np.asarray(points, dtype=np.float64))
    if places.shape[1:] != (3,) or not np.isfinite(places).all() or not 0.0 <= distance_max < np.inf:
        raise ConfigError("volume.points", "Points must be three finite numbers, and the distance must be at least 0.")
    resolution = volume.config.resolution
    scaled = np.clip(places / resolution + CENTRE, -1e9, 1e9)
    out = np.empty(len(places))
    occupied, limit = float(volume.config.log_odds_occupied), distance_max / resolution
    nearest_occupied(volume.belief, volume.blocks.corners, scaled, occupied, limit, out)
    return out * resolution


def voxels_in_box(volume: OccupancyVolume, low: ArrayLike, high: ArrayLike) -> tuple[Int64Array, Float32Array]:
    """Return the keys (n, 3) and log-odds (n,) of the known voxels with centres in the box, metres (3,) each."""
    resolution = volume.config.resolution
    first = np.ceil(np.asarray(low, dtype=np.float64) / resolution - 0.5) + CENTRE
    last = np.floor(np.asarray(high, dtype=np.float64) / resolution - 0.5) + CENTRE
    if first.shape != (3,) or last.shape != (3,) or np.isnan(first).any() or np.isnan(last).any():
        raise ConfigError("volume.box", f"A box needs two corners of three numbers each, not {low!r} and {high!r}.")
    corners = volume.blocks.corners
    near = np.flatnonzero(((corners + BLOCK > first) & (corners <= last)).all(axis=1))
    values = volume.values_of(near)
    slot, z, y, x = np.nonzero(~np.isnan(values))
    keys = corners[near][slot] + np.stack([x, y, z], axis=1)
    inside = ((keys >= first) & (keys <= last)).all(axis=1)
    return keys[inside], values[slot, z, y, x][inside]


def project(volume: OccupancyVolume, low: float = -np.inf, high: float = np.inf) -> OccupancyGrid:
    """Return a 2D map of the voxels whose centres are at heights ``low`` … ``high``, metres.

    A cell has the maximum log-odds of its column: it is occupied if any voxel is, and free if one is free and none
    occupied. ``low`` = ``high`` selects the layer of voxels that contains that height. Raises :class:`ConfigError` for
    a band without known voxels and :class:`LimitError` for a map that is too wide.
    """
    if not low <= high:
        raise ConfigError("volume.band", f"The bottom of the band must lie below its top, not {low:g} and {high:g} m.")
    resolution = volume.config.resolution
    a, b = np.clip((1.0 / resolution) * np.array([low, high]), -KEYS, KEYS)
    # A single height selects the voxels that contain it; a band selects those with centres in it.
    first, last = (np.floor(a), np.floor(a)) if low == high else (np.ceil(a - 0.5), np.floor(b - 0.5))
    first, last = int(first) + CENTRE, int(last) + CENTRE
    corners = volume.blocks.corners
    parts, values = volume.belief.parts[: len(corners)], volume.belief.values
    rows = np.isnan(values).view(np.uint64)[..., 0] != _ALL_OF_A_ROW  # rows with a known voxel, of each part (2, 2)
    layers = (rows[:, :, 0] | rows[:, :, 1])[parts].reshape(-1, 4, 4, 2).any(axis=2).reshape(-1, BLOCK)
    levels = corners[:, 2, None] + np.arange(BLOCK)
    some = (layers & (levels >= first) & (levels <= last)).any(axis=1)
    if not some.any():
        raise ConfigError("volume.band", f"The map has no known voxels between {low:g} and {high:g} m of height.")
    corners = corners[some]
    x0, y0, _ = corners.min(axis=0)
    cols, rows, _ = corners.max(axis=0) - corners.min(axis=0) + BLOCK
    origin = (float((x0 - CENTRE) * resolution), float((y0 - CENTRE) * resolution), 0.0)
    grid = OccupancyGrid(GridGeometry(resolution, int(rows), int(cols), origin))
    columns = np.full((rows, cols), np.nan, dtype=np.float32)
    project_columns(corners, parts[some], values, first, last, int(x0), int(y0), columns)
    seen = ~np.isnan(columns)
    grid.log_odds[seen] = columns[seen]
    grid.observed[seen] = True
    return grid
