"""Points and normals of the scans of a log, as all methods of matching take them."""

from __future__ import annotations

import numpy as np

from mapper.core.errors import ConfigError
from mapper.matching.kernels.scan_points import write_normals, write_points
from mapper.matching.kernels.types import ScanArrays
from mapper.sensors.scan import ScanLog

HALF_WIDTH = 2  #: beams on either side of one whose points make its normal, at least
REACH = 0.10  #: m: those of beams up to so far across do too, so that dense beams give no noisy normals
MOST_BEAMS = 20  #: on either side
LEAST_GAP = 0.10  #: m: neighbours in bearing nearer than this are neighbours on a surface at any range
MAX_THICKNESS = 0.02  #: m: points that scatter less than this across a line lie on it, however short it is
FEWEST_BEAMS = 3


def prepare_scans(
    log: ScanLog,
    first: int = 0,
    stop: int | None = None,
    *,
    range_max: float = np.inf,
    half_width: int = HALF_WIDTH,
    reach: float = REACH,
) -> ScanArrays:
    """Return the points of the scans ``first`` to ``stop`` of a log in the frame of its base, and their normals.

    Readings from the log's ``range_min`` up to the smaller of its ``range_max`` and the argument ``range_max``
    metres are points. The mount is applied, and the order is that of the bearing counter-clockwise; beams beyond one
    whole turn are left out. The normal of a point is that of the line through the points of ``half_width`` beams
    on either side and of those within ``reach`` metres, see :func:`mapper.matching.kernels.scan_points.write_normals`.

    Raises :class:`ConfigError` for scans that the log lacks, for fewer than three beams, and for beams that are not
    evenly spaced.
    """
    last = log.n_scans if stop is None else stop
    if not 0 <= first < last <= log.n_scans:
        raise ConfigError("matching.scans", f"The log has {log.n_scans} scans, not those from {first} to {last}.")
    if log.n_beams < FEWEST_BEAMS:
        raise ConfigError("matching.beams", f"Matching needs scans of {FEWEST_BEAMS} beams or more, not {log.n_beams}.")
    if log.bearings is not None:
        raise ConfigError("matching.bearings", "Matching needs beams at even angles, and those of this log are not.")
    if log.mounts is not None:
        raise ConfigError("matching.mount", "Matching needs a sensor that does not move on the robot.")
    angle_min, step = log.sweep
    ranges = log.ranges[first:last]
    n_beams = min(log.n_beams, round(2.0 * np.pi / abs(step)))
    ranges = ranges[:, :n_beams]
    if step < 0.0:
        ranges, angle_min, step = ranges[:, ::-1], angle_min + (n_beams - 1) * step, -step
    sensor_x, sensor_y, yaw = log.mount
    bearings = yaw + angle_min + step * np.arange(n_beams)
    scans = ScanArrays(
        np.empty((last - first, n_beams, 2), dtype=np.float32),
        np.empty((last - first, n_beams, 2), dtype=np.float32),
        np.empty((last - first, n_beams), dtype=np.uint8),
        float(bearings[0]),
        step,
        n_beams * step > 2.0 * np.pi - 0.5 * step,
        float(sensor_x),
        float(sensor_y),
    )
    beams = np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)
    write_points(
        np.ascontiguousarray(ranges),
        beams,
        scans.sensor_x,
        scans.sensor_y,
        log.range_min,
        min(log.range_max, range_max),
        scans.points,
        scans.kind,
    )
    write_normals(scans, half_width, reach, MOST_BEAMS, LEAST_GAP, MAX_THICKNESS)
    return scans
