"""Points and normals of the scans of a log, as all methods of matching take them."""

from __future__ import annotations

import numpy as np

from mapper.core.errors import ConfigError
from mapper.matching.beams import HALF_WIDTH, REACH, Beams, scan_rows
from mapper.matching.kernels.types import ScanArrays
from mapper.sensors.scan import ScanLog


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
    metres are points. The mount is applied, of a sensor that moves on the robot that of each scan, and the order is
    that of the bearing counter-clockwise; beams beyond one whole turn are left out. The normal of a point is that of
    the line through the points of ``half_width`` beams on either side and of those within ``reach`` metres, see
    :func:`mapper.matching.kernels.scan_points.write_normals`.

    Raises :class:`ConfigError` for scans that the log lacks, and as :meth:`mapper.matching.beams.Beams.of`.
    """
    last = log.n_scans if stop is None else stop
    if not 0 <= first < last <= log.n_scans:
        raise ConfigError("matching.scans", f"The log has {log.n_scans} scans, not those from {first} to {last}.")
    beams = Beams.of(log, range_max=range_max)
    scans = beams.room_for(last - first)
    ranges = np.ascontiguousarray(log.ranges[first:last, beams.indices])
    if log.mounts is None:
        beams.write(ranges, scans, half_width=half_width, reach=reach)
        return scans
    for n in range(last - first):
        placed = beams.at(log.mounts[first + n])
        scans.first[n], scans.sensor[n] = placed.first, placed.sensor
        placed.write(ranges[n : n + 1], scan_rows(scans, n, n + 1), half_width=half_width, reach=reach)
    return scans
