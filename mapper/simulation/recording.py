"""Recording of the scans of a live world, as a log that can be mapped again."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.sensors.scan import LaserScan, ScanLog, Trajectory
from mapper.simulation.faults import with_lengthened
from mapper.simulation.lidar import RANGE_MIN, SensorConfig

CAPACITY = 6000  #: scans: ten minutes at 10 Hz; 13 MB with 360 beams
FIRST_ROWS = 64  # initial capacity in scans; it is doubled when full
PLACES = (0.5, 1.0, 2.0, 4.0, 8.0)  # metres: sides of the squares used to thin a full recording
TURNS = 4  # headings distinguished in each square


class Recording:
    """Scans and poses of one sensor, in arrays that grow up to ``capacity`` scans.

    Besides the true poses it holds those reported by odometry, and for each reading the length added by polished walls,
    see :mod:`mapper.simulation.faults`.

    A full recording is thinned: of the scans taken in one place (a square of 0.5 m, one of four headings) only the
    newest n are kept, with the largest n that frees half of the capacity. If even one scan per place is too many, the
    squares are enlarged. So the map of a recording covers every place that the robot has observed, and most scans are
    dropped where the robot was most often, which the clamp compensates. Scans keep their order. :attr:`generation`
    counts the thinnings: while it is unchanged, a log of the recording extends the earlier log; when it changes, the
    map has to be recomputed. Logs returned earlier are never modified.
    """

    def __init__(
        self, sensor: SensorConfig, capacity: int = CAPACITY, mount: Sequence[float] = (0.0, 0.0, 0.0)
    ) -> None:
        if capacity < 2:
            raise ConfigError("recording.capacity", f"A recording must hold at least 2 scans, not {capacity!r}.")
        self.sensor = sensor
        self.capacity = capacity
        self.mount = (float(mount[0]), float(mount[1]), float(mount[2]))
        self.generation = 0
        self._taken = 0
        self._start_empty()

    def _start_empty(self) -> None:
        rows = min(self.capacity, FIRST_ROWS)
        self._n = 0
        self._ranges = np.empty((rows, self.sensor.n_readings), dtype=np.float32)
        self._longer = np.zeros((rows, self.sensor.n_readings), dtype=np.float16)
        self._poses = np.empty((rows, 3))
        self._odometry = np.empty((rows, 3))
        self._stamps = np.empty(rows, dtype=np.int64)
        self._numbers = np.empty(rows, dtype=np.int64)

    def __len__(self) -> int:
        return self._n

    @property
    def numbers(self) -> NDArray[np.int64]:
        """Indices (n,) of these scans among all that were appended, from 0, ascending."""
        return self._numbers[: self._n]

    def fits(self, sensor: SensorConfig) -> bool:
        """Return whether scans of ``sensor`` can be appended: a log has one set of beams and one range.

        Noise and scan rate may differ. If it returns false, a new recording has to be started.
        """
        mine = self.sensor
        return (sensor.n_readings, sensor.cone, sensor.field_of_view, sensor.range_max) == (
            mine.n_readings,
            mine.cone,
            mine.field_of_view,
            mine.range_max,
        )

    def append(
        self,
        scan: LaserScan,
        base_pose: Sequence[float] | NDArray[np.float64],
        odometry: Sequence[float] | NDArray[np.float64] | None = None,
        longer: NDArray[np.float16] | None = None,
    ) -> None:
        """Add a scan and the base's pose ``T_map_base`` (3,) at it. Raises :class:`ConfigError` for a misfit.

        ``odometry`` (3,) is that pose as reported by the wheels, None for the true one; ``longer`` (n_beams,) are the
        metres by which polished walls lengthen each reading, +inf for no return, None for no effect.
        """
        expected = (self.sensor.n_readings, self.sensor.angle_min, self.sensor.angle_increment, self.sensor.range_max)
        actual = (len(scan.ranges), scan.angle_min, scan.angle_increment, scan.range_max)
        if actual != expected:
            raise ConfigError(
                "recording.scan",
                f"A scan of (beams, angle_min, angle_increment, range_max) {actual} is not of {expected}.",
            )
        if np.shape(base_pose) != (3,) or not all(map(math.isfinite, base_pose)):
            pose = np.asarray(base_pose, dtype=np.float64).tolist()
            raise ConfigError("recording.pose", f"A pose must be three finite numbers, not {pose!r:.80}.")
        if self._n == self.capacity:
            self._thin()
        if self._n == len(self._ranges):
            self._resize(np.arange(self._n), min(self.capacity, 2 * self._n))
        self._ranges[self._n] = scan.ranges
        self._poses[self._n] = base_pose
        self._odometry[self._n] = base_pose if odometry is None else odometry
        self._longer[self._n] = 0.0 if longer is None else longer
        self._stamps[self._n] = scan.stamp_ns
        self._numbers[self._n] = self._taken
        self._taken += 1
        self._n += 1

    def reported(self, rows: slice, *, specular: bool) -> NDArray[np.float32]:
        """Return readings (n, n_beams), with ``specular`` as affected by polished walls."""
        ranges = self._ranges[rows]
        return with_lengthened(ranges, self._longer[rows], self.sensor.range_max) if specular else ranges

    def as_log(self, *, specular: bool = False, corrected: NDArray[np.float64] | None = None) -> ScanLog:
        """Return the recording so far as a log with the trajectories "true" and "odometry".

        ``corrected`` (n, 3) are poses for a third one, "slam". The log's arrays are views without copies, except for
        the readings with ``specular``.
        """
        ranges = self.reported(slice(0, self._n), specular=specular)
        described = "Corrected by SLAM while the robot drives."
        slam = {} if corrected is None else {"slam": Trajectory(corrected, described, "map")}
        return ScanLog(
            ranges,
            self.sensor.angle_min,
            self.sensor.angle_increment,
            RANGE_MIN,
            self.sensor.range_max,
            self._stamps[: self._n],
            {
                "true": Trajectory(self._poses[: self._n], "The simulated robot’s true poses.", "map"),
                "odometry": Trajectory(
                    self._odometry[: self._n], "What its wheels report: the truth with a drift.", "odom"
                ),
                **slam,
            },
            self.mount,
            beam_width=self.sensor.cone,
            name="live world",
            format="simulation",
        )

    def clear(self) -> None:
        """Remove all scans."""
        self._start_empty()
        self.generation += 1

    def _thin(self) -> None:
        """Keep the newest n scans of each place, with the largest n that leaves half of the capacity free."""
        room = self.capacity // 2
        heading = np.floor(np.mod(self._poses[: self._n, 2], 2.0 * np.pi) / (2.0 * np.pi) * TURNS)
        for side in PLACES:
            square = np.floor(self._poses[: self._n, :2] / side)
            places, group = np.unique(np.column_stack([square, heading]), axis=0, return_inverse=True)
            if len(places) <= room:
                break
        # Number of newer scans in the place of each scan: sort by place, newest first, and count within it.
        order = np.lexsort((-np.arange(self._n), group))
        starts = np.flatnonzero(np.diff(group[order], prepend=-1))
        newer = np.empty(self._n, dtype=np.int64)
        newer[order] = np.arange(self._n) - np.repeat(starts, np.diff([*starts, self._n]))
        kept_with = np.cumsum(np.bincount(newer))  # number of scans kept for n = index + 1
        n = max(1, int(np.searchsorted(kept_with, room, side="right")))
        keep = np.flatnonzero(newer < n)[-room:]  # all of them, unless no square was large enough
        self._resize(keep, len(self._ranges))
        self._n = len(keep)
        self.generation += 1

    def _resize(self, keep: NDArray[np.int64], rows: int) -> None:
        """Move the scans ``keep`` to the front of new arrays of ``rows`` rows; the old arrays are not modified."""
        for name in ("_ranges", "_longer", "_poses", "_odometry", "_stamps", "_numbers"):
            old = getattr(self, name)
            new = np.empty((rows, *old.shape[1:]), dtype=old.dtype)
            new[: len(keep)] = old[keep]
            setattr(self, name, new)
