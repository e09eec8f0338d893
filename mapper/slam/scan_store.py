"""The matched scans as points and normals in the base frame, in arrays that grow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.matching.kernels.scan_points import write_normals, write_points
from mapper.matching.kernels.types import NO_POINT, ScanArrays
from mapper.matching.prepare import HALF_WIDTH, LEAST_GAP, MAX_THICKNESS, MOST_BEAMS, REACH
from mapper.sensors.scan import ScanLog

FIRST_ROWS = 512  #: scans that the arrays hold at the start; they double
FULL_TURN = 2.0 * np.pi


class ScanStore:
    """Scans of one sensor, prepared for matching, in the order in which they were appended.

    Beams are turned into the order of their bearing in the base frame, seen from above; of more than ``max_beams``
    each second, third … is taken. Readings from ``range_max`` metres on are left out. Raises :class:`ConfigError` for
    sonars and for a sensor of one beam.
    """

    def __init__(self, log: ScanLog, range_max: float, max_beams: int) -> None:
        if log.bearings is not None or log.beam_width > 0.0:
            raise ConfigError("slam.sonar", "SLAM needs a lidar: a sonar's readings are too wide to be matched.")
        if log.n_beams < 2:
            raise ConfigError("slam.beams", f"SLAM needs scans of more than one beam, not of {log.n_beams}.")
        if log.mounts is not None:
            raise ConfigError("slam.mount", "SLAM needs a lidar that does not move on the robot.")
        angle_min, increment = log.sweep
        turn = int(np.floor(FULL_TURN / abs(increment) + 1e-6))
        used = min(log.n_beams, max(turn, 2))
        stride = -(-used // max(2, max_beams))
        self._beams = np.arange(0, used, stride)
        x, y, yaw = log.mount
        bearings = yaw + angle_min + increment * self._beams
        if increment < 0.0:
            self._beams, bearings = self._beams[::-1], bearings[::-1]
        self._directions = np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)
        self._first, self._step = float(bearings[0]), abs(float(increment)) * stride
        self._wraps = len(bearings) * self._step > FULL_TURN - 0.5 * self._step
        self._x, self._y = float(x), float(y)
        self._range_min = max(float(log.range_min), 0.01)
        self._range_max = min(range_max, np.nextafter(log.range_max, np.inf))
        self._n = 0
        self._points = np.empty((FIRST_ROWS, len(bearings), 2), dtype=np.float32)
        self._normals = np.empty_like(self._points)
        self._kind = np.empty(self._points.shape[:2], dtype=np.uint8)
        self.arrays = self._slice(0, FIRST_ROWS)  #: of all scans; valid until the next :meth:`append`

    def __len__(self) -> int:
        return self._n

    @property
    def n_beams(self) -> int:
        """Beams of each scan that are used."""
        return len(self._directions)

    def append(self, ranges: NDArray[np.float32]) -> int:
        """Add a scan of the log's ranges (n_beams,); return its number here."""
        if self._n == len(self._points):
            for name in ("_points", "_normals", "_kind"):
                old = getattr(self, name)
                grown = np.empty((2 * len(old), *old.shape[1:]), dtype=old.dtype)
                grown[: len(old)] = old
                setattr(self, name, grown)
            self.arrays = self._slice(0, len(self._points))
        one = self._slice(self._n, self._n + 1)
        taken = np.ascontiguousarray(ranges[self._beams], dtype=np.float32)[np.newaxis]
        write_points(taken, self._directions, self._x, self._y, self._range_min, self._range_max, one.points, one.kind)
        write_normals(one, HALF_WIDTH, REACH, MOST_BEAMS, LEAST_GAP, MAX_THICKNESS)
        self._n += 1
        return self._n - 1

    def count(self, scan: int) -> int:
        """Return the number of points of a scan."""
        return int(np.count_nonzero(self._kind[scan] != NO_POINT))

    def farthest(self, scan: int) -> float:
        """Return the distance of a scan's farthest point from the base, metres; 0 for a scan without points."""
        points = self._points[scan][self._kind[scan] != NO_POINT]
        return float(np.sqrt((points.astype(np.float64) ** 2).sum(axis=-1).max())) if len(points) else 0.0

    def _slice(self, begin: int, end: int) -> ScanArrays:
        return ScanArrays(
            self._points[begin:end],
            self._normals[begin:end],
            self._kind[begin:end],
            self._first,
            self._step,
            self._wraps,
            self._x,
            self._y,
        )
