"""Matched scans as points and normals in the base frame, in growing arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.matching.beams import Beams, scan_rows
from mapper.matching.kernels.types import NO_POINT, ScanArrays
from mapper.sensors.joint_log import part_of_scan, sensor_numbers, sensors_of
from mapper.sensors.scan import ScanLog

FIRST_ROWS = 512  #: initial capacity in scans; it is doubled when full

Kind = TypeVar("Kind", bound=np.generic)


class ScanStore:
    """Scans of one or several sensors, prepared for matching, in insertion order.

    Beams are ordered by bearing in the base frame, seen from above; if there are more than ``max_beams``, every second,
    third … is used. Readings of ``range_max`` metres or more are ignored. ``sensors`` are the sensor numbers of the
    logs, None: :func:`sensor_numbers`. Raises :class:`ConfigError` for sonars and for a sensor of fewer than three
    beams.
    """

    def __init__(
        self, logs: Sequence[ScanLog], range_max: float, max_beams: int, sensors: Sequence[int] | None = None
    ) -> None:
        for log in logs:
            if log.bearings is not None or log.beam_width > 0.0:
                raise ConfigError("slam.sonar", "SLAM needs a lidar: a sonar’s readings are too wide to be matched.")
        below = float(np.nextafter(range_max, 0.0))
        numbers = sensor_numbers(logs) if sensors is None else sensors
        self.sensor_numbers = [int(number) for number in numbers]  #: sensor of each log
        self._beams = [Beams.of(log, range_max=below, most=max_beams) for log in logs]
        self.can_deskew = any(beam.times.any() for beam in self._beams)  #: whether the times of beams are known
        self._n = 0
        self.n_beams = max(len(beam) for beam in self._beams)  #: maximum over the sensors
        self._rows = ScanArrays(
            np.empty((FIRST_ROWS, self.n_beams, 2), dtype=np.float32),
            np.empty((FIRST_ROWS, self.n_beams, 2), dtype=np.float32),
            np.zeros((FIRST_ROWS, self.n_beams), dtype=np.uint8),
            np.empty(FIRST_ROWS, dtype=np.int64),
            np.empty(FIRST_ROWS),
            np.empty(FIRST_ROWS),
            np.empty(FIRST_ROWS, dtype=np.bool_),
            np.empty((FIRST_ROWS, 2)),
        )
        self._sensor = np.zeros(FIRST_ROWS, dtype=np.int64)
        self._mounts = np.zeros((FIRST_ROWS, 3))
        # Ranges are kept if points are to be deskewed later.
        self._ranges = np.empty((FIRST_ROWS if self.can_deskew else 0, self.n_beams), dtype=np.float32)

    def __len__(self) -> int:
        return self._n

    @property
    def n_sensors(self) -> int:
        """Number of sensors."""
        return max(self.sensor_numbers) + 1

    @property
    def arrays(self) -> ScanArrays:
        """Return all scans; valid until the next :meth:`append`. Rows beyond the number of scans are unused."""
        return self._rows

    @property
    def least_step(self) -> float:
        """The smallest angle between beams of a sensor, radians."""
        return min(beam.step for beam in self._beams)

    def append(
        self,
        ranges: NDArray[np.float32],
        sensor: int = 0,
        velocity: Float64Array | None = None,
        mount: Float64Array | None = None,
    ) -> int:
        """Add a scan of the ranges (n_beams,) of the log with index ``sensor``; return the scan's index here.

        ``velocity`` (3,) is the base's during the scan, in its own frame, metres and radians per second. ``mount``
        (3,), ``T_base_laser``, is the mount of a sensor that moves on the robot; None: as in its log.
        """
        if self._n == len(self._sensor):
            self._grow()
        n, beams = self._n, self._beams[sensor]
        beams = beams if mount is None else beams.at(mount)
        self._sensor[n], self._mounts[n] = sensor, beams.mount
        self._rows.n_beams[n], self._rows.first[n], self._rows.step[n] = len(beams), beams.first, beams.step
        self._rows.wraps[n], self._rows.sensor[n] = beams.wraps, beams.sensor
        self._rows.kind[n] = NO_POINT
        used = np.ascontiguousarray(ranges[beams.indices], dtype=np.float32)
        if self.can_deskew:
            self._ranges[n, : len(beams)] = used
        self._write(n, used, velocity)
        self._n += 1
        return n

    def drop_last(self) -> None:
        """Remove the last appended scan."""
        self._n -= 1

    def deskew(self, velocities: Float64Array) -> None:
        """Rewrite the points and normals of all scans for these velocities (n, 3) of the base, see :meth:`append`.

        Has no effect if no sensor states the times of its beams.
        """
        if self.can_deskew:
            for n in range(self._n):
                self._write(n, self._ranges[n, : self._rows.n_beams[n]], velocities[n])

    def _write(self, n: int, ranges: NDArray[np.float32], velocity: Float64Array | None) -> None:
        rows = scan_rows(self._rows, n, n + 1)
        velocities = None if velocity is None else velocity[np.newaxis]
        self._beams[self._sensor[n]].at(self._mounts[n]).write(ranges[np.newaxis], rows, velocities)

    def _grow(self) -> None:
        rows = self._rows
        self._rows = ScanArrays(
            _doubled(rows.points),
            _doubled(rows.normals),
            _doubled(rows.kind),
            _doubled(rows.n_beams),
            _doubled(rows.first),
            _doubled(rows.step),
            _doubled(rows.wraps),
            _doubled(rows.sensor),
        )
        self._sensor, self._ranges = _doubled(self._sensor), _doubled(self._ranges)
        self._mounts = _doubled(self._mounts)

    def count(self, scan: int) -> int:
        """Return the number of points of a scan."""
        return int(np.count_nonzero(self._rows.kind[scan] != NO_POINT))

    def farthest(self, scan: int) -> float:
        """Return the distance of a scan's farthest point from the base, metres; 0 for a scan without points."""
        points = self._rows.points[scan][self._rows.kind[scan] != NO_POINT]
        return float(np.sqrt((points.astype(np.float64) ** 2).sum(axis=-1).max())) if len(points) else 0.0


def scans_of(log: ScanLog, scans: Sequence[int]) -> ScanArrays:
    """Return the points and normals of some scans of a log, of any of its sensors, in the order of ``scans``.

    Raises the errors of :class:`ScanStore`.
    """
    store = ScanStore(sensors_of(log), np.inf, log.n_beams)
    sensor = part_of_scan(log)
    for scan in scans:
        store.append(log.ranges[scan], int(sensor[scan]), mount=log.mount_of(scan))
    return scan_rows(store.arrays, 0, len(scans))


def _doubled(old: NDArray[Kind]) -> NDArray[Kind]:
    """Return the array with as many rows of zeros appended."""
    return np.concatenate([old, np.zeros_like(old)])
