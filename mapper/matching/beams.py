"""The beams of a sensor in the form that all matching methods use, and their readings as points."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mapper.core.array_types import Float32Array, Float64Array, Int64Array
from mapper.core.errors import ConfigError
from mapper.matching.kernels.scan_points import write_normals, write_points
from mapper.matching.kernels.types import ScanArrays
from mapper.sensors.scan import ScanLog

HALF_WIDTH = 2  #: minimum number of beams on either side of a point that contribute to its normal
REACH = 0.10  #: m: beams within this distance across also contribute, so that dense beams have no noisy normals
MOST_BEAMS = 20  #: on either side
LEAST_GAP = 0.10  #: m: neighbours in bearing closer than this are always neighbours on a surface
MAX_THICKNESS = 0.02  #: m: points that scatter less than this across a line lie on it, however short it is
FEWEST_BEAMS = 3
LEAST_RANGE = 0.01  #: m: shorter readings are not walls


@dataclass(frozen=True, slots=True)
class Beams:
    """The beams of a sensor in the order of their bearing in the base frame, counter-clockwise seen from above.

    They belong to the sensor at ``mount`` (3,), ``T_base_laser`` of the log's first scan; see :meth:`at`. ``indices``
    (n,) are their indices in the log, ``directions`` (n, 2) their directions, ``step`` radians apart starting at
    ``first``; ``sensor`` (2,) is their origin, metres, and ``times`` (n,) the time of each after the first, seconds.
    Readings from ``range_min`` to ``range_max`` metres are points.
    """

    mount: tuple[float, float, float]
    indices: Int64Array
    directions: Float64Array
    first: float
    step: float
    wraps: bool
    sensor: Float64Array
    times: Float64Array
    range_min: float
    range_max: float

    @classmethod
    def of(cls, log: ScanLog, *, range_max: float = np.inf, most: int | None = None) -> Beams:
        """Return the beams of a log's sensor; if there are more than ``most``, every second, third … beam.

        Beams beyond one full turn are omitted, and readings beyond the smaller of the log's ``range_max`` and the
        argument. Raises :class:`ConfigError` for fewer than three beams, and for beams that are not evenly spaced.
        """
        if log.n_beams < FEWEST_BEAMS:
            raise ConfigError(
                "matching.beams", f"Matching needs scans of {FEWEST_BEAMS} beams or more, not {log.n_beams}."
            )
        if log.bearings is not None:
            raise ConfigError(
                "matching.bearings", "Matching needs beams at even angles, and those of this log are not."
            )
        angle_min, step = log.sweep
        in_turn = min(log.n_beams, max(round(2.0 * np.pi / abs(step)), FEWEST_BEAMS))
        stride = 1 if most is None else -(-in_turn // max(FEWEST_BEAMS, most))
        indices = np.arange(0, in_turn, stride)
        if step < 0.0:
            indices = indices[::-1].copy()
        x, y, yaw = log.mount
        bearings = yaw + angle_min + step * indices
        spacing = abs(step) * stride
        return cls(
            (x, y, yaw),
            indices,
            np.stack([np.cos(bearings), np.sin(bearings)], axis=-1),
            float(bearings[0]),
            spacing,
            bool(len(indices) * spacing > 2.0 * np.pi - 0.5 * spacing),
            np.array([x, y], dtype=np.float64),
            np.asarray(indices * log.time_increment, dtype=np.float64),
            max(float(log.range_min), LEAST_RANGE),
            float(min(log.range_max, range_max)),
        )

    def at(self, mount: Float64Array) -> Beams:
        """Return the beams of the sensor at another mount (3,), ``T_base_laser``, for sensors that move on the
        robot.
        """
        x, y, yaw = (float(value) for value in mount)
        if (x, y, yaw) == self.mount:
            return self
        first = self.first + (yaw - self.mount[2])
        bearings = first + self.step * np.arange(len(self))
        directions = np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)
        return replace(self, mount=(x, y, yaw), directions=directions, first=first, sensor=np.array([x, y]))

    def __len__(self) -> int:
        return len(self.indices)

    def room_for(self, n_scans: int) -> ScanArrays:
        """Allocate arrays for a number of scans of this sensor; points, normals and kinds are not yet written."""
        n = len(self)
        return ScanArrays(
            np.empty((n_scans, n, 2), dtype=np.float32),
            np.empty((n_scans, n, 2), dtype=np.float32),
            np.empty((n_scans, n), dtype=np.uint8),
            np.full(n_scans, n, dtype=np.int64),
            np.full(n_scans, self.first),
            np.full(n_scans, self.step),
            np.full(n_scans, self.wraps),
            np.tile(self.sensor, (n_scans, 1)),
        )

    def write(
        self,
        ranges: Float32Array,
        scans: ScanArrays,
        velocities: Float64Array | None = None,
    ) -> None:
        """Write the points, normals and kinds of the readings ``ranges`` (n_scans, n) of these beams into ``scans``.

        ``velocities`` (n_scans, 3) are those of the base in its own frame, metres and radians per second. With them the
        points are relative to the base's pose at the time of the first beam (:func:`write_points`).
        """
        n_scans = len(ranges)
        write_points(
            ranges,
            self.directions,
            self.sensor,
            self.range_min,
            self.range_max,
            self.times,
            np.zeros((n_scans, 3)) if velocities is None else velocities,
            scans.points,
            scans.kind,
        )
        write_normals(scans, HALF_WIDTH, REACH, MOST_BEAMS, LEAST_GAP, MAX_THICKNESS)


def scan_rows(scans: ScanArrays, begin: int, end: int) -> ScanArrays:
    """Return the scans [begin, end), sharing memory."""
    rows = slice(begin, end)
    return ScanArrays(
        scans.points[rows],
        scans.normals[rows],
        scans.kind[rows],
        scans.n_beams[rows],
        scans.first[rows],
        scans.step[rows],
        scans.wraps[rows],
        scans.sensor[rows],
    )


def prepare_scans(log: ScanLog, first: int = 0, stop: int | None = None) -> ScanArrays:
    """Return the points of the scans [first, stop) of a log in its base frame, with normals.

    Readings from the log's ``range_min`` to its ``range_max`` are points. The mount is applied, per scan if the sensor
    moves on the robot, and the points are ordered by bearing, counter-clockwise; beams beyond one full turn are
    omitted. The normal of a point is that of the line through the points of :data:`HALF_WIDTH` beams on either side and
    those within :data:`REACH` metres, see :func:`mapper.matching.kernels.scan_points.write_normals`. Raises
    :class:`ConfigError` for scans that the log lacks, and the errors of :meth:`mapper.matching.beams.Beams.of`.
    """
    last = log.n_scans if stop is None else stop
    if not 0 <= first < last <= log.n_scans:
        raise ConfigError("matching.scans", f"The log has {log.n_scans} scans, not those from {first} to {last}.")
    beams = Beams.of(log)
    scans = beams.room_for(last - first)
    ranges = np.ascontiguousarray(log.ranges[first:last, beams.indices])
    if log.mounts is None:
        beams.write(ranges, scans)
        return scans
    for n in range(last - first):
        placed = beams.at(log.mounts[first + n])
        scans.first[n], scans.sensor[n] = placed.first, placed.sensor
        placed.write(ranges[n : n + 1], scan_rows(scans, n, n + 1))
    return scans
