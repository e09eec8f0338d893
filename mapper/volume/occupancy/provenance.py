"""Updates of one voxel by each scan, with their beams."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float32Array, Int64Array
from mapper.core.errors import WorkCancelledError
from mapper.volume.blocks import BLOCK
from mapper.volume.kernels.rays import mark_rays
from mapper.volume.kernels.types import Box
from mapper.volume.occupancy.parameters import VolumeConfig
from mapper.volume.occupancy.volume import FORGET_BELOW, OccupancyVolume, centres_of, keys_of
from mapper.volume.placed_scan import PlacedScan

MOST_BEAMS = 64  #: maximum number of a scan's beam ends returned


@dataclass(frozen=True, slots=True)
class VoxelUpdate:
    """Update of a voxel by scan ``scan``, counted from 0.

    ``is_hit`` means that a beam ended in it; otherwise ``beams`` of them passed it, or at least that many if there are
    more than :data:`MOST_BEAMS`. ``before`` and ``after`` are the log-odds, ``before`` including the decay until then
    and NaN if unknown. ``origin`` (3,) is the sensor position, None if unknown, and ``ends`` (beams, 3) are the ends of
    the beams, metres.
    """

    scan: int
    is_hit: bool
    beams: int
    before: float
    after: float
    origin: Float32Array | None
    ends: Float32Array


def why_voxel(
    scans: Iterable[PlacedScan],
    config: VolumeConfig,
    key: Int64Array,
    may_continue: Callable[[], bool] = lambda: True,
) -> list[VoxelUpdate]:
    """Return the effect of ``scans``, in order, on the voxel with ``key`` (3,), omitting scans without effect.

    The last log-odds are those of the map of these scans, unless it has decayed since. Raises
    :class:`WorkCancelledError` between two scans unless ``may_continue``.
    """
    volume = OccupancyVolume(config)
    place = centres_of(key[None], config.resolution)[0]
    value = np.float32(np.nan)
    updates = []
    last_ns = 0
    for number, scan in enumerate(scans):
        if not may_continue():
            raise WorkCancelledError("volume.cancelled", "Asking why a voxel is so was cancelled.")
        if last_ns and scan.stamp_ns > last_ns and config.half_life > 0.0 and not np.isnan(value):
            value *= np.float32(0.5 ** ((scan.stamp_ns - last_ns) * 1e-9 / config.half_life))
            value = np.float32(np.nan) if abs(value) < np.float32(FORGET_BELOW) else value
        last_ns = scan.stamp_ns or last_ns
        crossing = _beams(volume, scan, key, place)
        if crossing is None:
            continue
        is_hit, beams, ends = crossing
        before = value
        step = config.log_odds_hit if is_hit else config.log_odds_miss
        value = np.float32(0.0 if np.isnan(value) else value) + step
        value = min(max(value, config.log_odds_min), config.log_odds_max)
        origin = None if scan.origin is None else scan.origin.astype(np.float32)
        updates.append(VoxelUpdate(number, is_hit, beams, float(before), float(value), origin, ends))
    return updates


def _beams(
    volume: OccupancyVolume, scan: PlacedScan, key: Int64Array, place: Float32Array
) -> tuple[bool, int, Float32Array] | None:
    """Return whether beams of a scan end in a voxel, how many end in or pass it, and their ends; None without any."""
    resolution = volume.config.resolution
    start = np.zeros(3, np.float32) if scan.origin is None else scan.origin.astype(np.float32)
    points = np.ascontiguousarray(scan.points, dtype=np.float32)
    rays, keys, hits, _ = volume.rays_of(points, start)
    if (hits == key).all(axis=1).any():
        # A scan's beams may be those to voxel centres, but the ends in this voxel are the scan's points.
        point_keys, inside = keys_of(points, resolution)
        ended = points[inside & (point_keys == key).all(axis=1)]
        return True, len(ended), ended[:MOST_BEAMS]
    if scan.origin is None:
        return None
    near = _near(start, rays, place, resolution)
    rays, keys = rays[near], keys[near]
    first = keys_of(start[None], resolution)[0][0]
    corner = key // BLOCK * BLOCK
    box = Box(int(corner[0]), int(corner[1]), int(corner[2]), BLOCK, BLOCK, BLOCK)
    x, y, z = (int(k) for k in key - corner)
    marks = np.zeros(BLOCK**3, dtype=np.uint8)
    at = (z * BLOCK + y) * BLOCK + x

    def passes(some: slice) -> bool:
        marks[:] = 0
        mark_rays(start, rays[some], first, keys[some], resolution, box, marks)
        return bool(marks[at])

    # First all at once, because for most scans no beam passes the voxel.
    if not passes(slice(None)):
        return None
    passing = []
    for k in range(len(rays)):
        if passes(slice(k, k + 1)):
            passing.append(k)
            if len(passing) == MOST_BEAMS:
                break
    return False, len(passing), rays[passing]


def _near(start: Float32Array, ends: Float32Array, place: Float32Array, resolution: float) -> Int64Array:
    """Return the indices (m,) of the beams that pass the voxel's centre more closely than its corners are."""
    away = ends.astype(np.float64) - start
    to = place.astype(np.float64) - start
    length = np.maximum((away * away).sum(axis=1), 1e-12)
    share = np.clip(away @ to / length, 0.0, 1.0)
    apart = share[:, None] * away - to
    limit = 0.9 * resolution + 1e-3  # half of a voxel's diagonal is 0.866 of its side
    return np.flatnonzero((apart * apart).sum(axis=1) <= limit * limit)
