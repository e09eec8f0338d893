"""Scans with their poses: batches of one sensor's scans, the input of all updates, and single scans placed in the map.

The mount is corrected, fields are computed, and for "hit" no return is replaced by the maximum range. Deskewed beams
are scans of one beam each, in the order of the log: beam k of scan t has the number t · n_beams + k, as readings have
everywhere.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import compose, inverse
from mapper.grid import GridGeometry
from mapper.mapping.kernels.bresenham import reach
from mapper.mapping.kernels.types import ReadingFilter, Scans
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.update_plan import UpdatePlan, part_of, plan_update
from mapper.sensors.beam_fields import beam_fields, cones
from mapper.sensors.joint_log import JointLog
from mapper.sensors.motion import Motion, seconds
from mapper.sensors.scan import LaserScan, RangeScan, ScanLog, SonarScan

_CHUNK_READINGS = 1 << 19  # readings planned at once: each chunk costs two rounds of the threads
_DESKEWED_READINGS = 1 << 18  # in one batch: each needs about 200 bytes for its own pose and derived values
_NO_FIELDS = np.empty((0, 4))


@dataclass(frozen=True)  # without slots: cached properties need a __dict__
class ScanBatch:
    """Scans of one sensor with their poses."""

    ranges: NDArray[np.float32]  #: (n_scans, n_beams), m
    sensor_poses: NDArray[np.float64]  #: (n_scans, 3), T_map_laser
    angles: NDArray[np.float64]  #: (n_beams, 4), see mapper.sensors.beam_fields.beam_fields; (0, 4) if unused
    fields: NDArray[
        np.float64
    ]  #: (n_beams, 4), see mapper.sensors.beam_fields.beam_fields; (0, 4) if no fields are used
    range_min: float  #: m
    range_max: float  #: m
    numbers: NDArray[np.int64]  #: (n_scans,) scan indices; the rows of one scan (its deskewed beams) are consecutive

    @cached_property
    def sensors(self) -> NDArray[np.float64]:
        """(n_scans, 4): x, y (m), cos θ, sin θ."""
        theta = np.ascontiguousarray(self.sensor_poses[:, 2])
        return np.column_stack([self.sensor_poses[:, :2], np.cos(theta), np.sin(theta)])

    @cached_property
    def beams(self) -> NDArray[np.float64]:
        """(n_beams, 2): cosine and sine of the bearings."""
        return directions(self.angles.tobytes())

    def headings(self, geometry: GridGeometry) -> NDArray[np.float64]:
        """Return the cosine and sine (n_scans, 2) of the sensor's heading relative to the lattice."""
        if geometry.origin[2] == 0.0:
            return np.ascontiguousarray(self.sensors[:, 2:])
        theta = np.ascontiguousarray(self.sensor_poses[:, 2] - geometry.origin[2])
        return np.column_stack([np.cos(theta), np.sin(theta)])

    def scans_on(self, geometry: GridGeometry) -> Scans:
        """Return all scans in the form that the kernels use, on the lattice of ``geometry``."""
        return Scans(self.ranges, self.sensors, self.beams, self.fields, self.headings(geometry), self.numbers)

    def chunks_on(self, geometry: GridGeometry) -> list[Scans]:
        """Return the scans of :meth:`scans_on` in chunks of about half a million readings; scans are not split."""
        step = max(1, _CHUNK_READINGS // max(1, self.ranges.shape[1]))
        scans, n = self.scans_on(geometry), len(self.ranges)
        ends = scan_ends(self.numbers)
        edges = np.unique([0, *ends[np.searchsorted(ends, range(step, n, step))], n])
        return [part_of(scans, first, stop) for first, stop in pairwise(edges.tolist())]

    def bounds(self, reading_filter: ReadingFilter, *, fields: bool) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the minimum and maximum x, y (2,), metres in the map, of the sensors and of everything that they
        observe.

        With ``fields`` the whole field of each beam counts, otherwise only its axis.
        """
        out = np.array([np.inf, np.inf, -np.inf, -np.inf])
        directions = [self.beams]
        if fields and len(self.fields):
            # A field ends in an arc, which lies within the polygon of three corners around it: right, middle and left.
            right, left = self.fields[:, :2], self.fields[:, 2:]
            cos_half = np.minimum(np.sum(right * self.beams, axis=1), np.sum(left * self.beams, axis=1))
            stretch = 1.0 / np.cos(0.5 * np.arccos(np.clip(cos_half, 0.0, 1.0)))[:, np.newaxis]
            directions = [right * stretch, self.beams * stretch, left * stretch]
        for direction in directions:
            reach(self.ranges, self.sensors, np.ascontiguousarray(direction), reading_filter, out)
        return out[:2], out[2:]


@lru_cache(maxsize=32)  # the scans of a live robot, and of all robots of one kind, have the same bearings
def directions(angles: bytes) -> NDArray[np.float64]:
    """Return the cosine and sine (n, 2) of float64 angles, radians. The array is shared and must not be modified."""
    radians = np.frombuffer(angles)
    return np.column_stack([np.cos(radians), np.sin(radians)])


def scan_ends(numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the row after the last row of each scan. ``numbers`` (n_rows,) are those of :class:`Scans`."""
    return np.flatnonzero(np.diff(numbers, append=numbers[-1:] - 1)) + 1


def is_deskewed(log: ScanLog, plan: UpdatePlan, trajectory: str | None) -> bool:
    """Return whether beams get individual poses if the trajectory allows it."""
    return plan.deskew != "off" and log.can_deskew(trajectory)


def deskewed_scans(log: ScanLog, plan: UpdatePlan, trajectory: str | None) -> NDArray[np.bool_]:
    """Return which scans (n_scans,) are deskewed."""
    if not is_deskewed(log, plan, trajectory):
        return np.zeros(log.n_scans, dtype=np.bool_)
    if plan.deskew == "on":
        return np.ones(log.n_scans, dtype=np.bool_)
    return _are_dense(log, Motion.of(log, trajectory), _shifted(log, plan, trajectory))


def covered_scans(log: ScanLog, plan: UpdatePlan, trajectory: str | None) -> NDArray[np.bool_]:
    """Return which scans (n_scans,) have a known pose; others contribute nothing.

    With the time offset applied, they lie between the first and the last pose.
    """
    robot_path = log.trajectory(trajectory)
    known = np.ones(log.n_scans, dtype=np.bool_) if robot_path.is_known is None else robot_path.is_known
    if robot_path.offset_of_stamps(plan.time_offset) == 0.0 or log.n_scans == 0:
        return known
    return known & Motion.of(log, trajectory).covers(_shifted(log, plan, trajectory))


def _shifted(log: ScanLog, plan: UpdatePlan, trajectory: str | None) -> NDArray[np.float64]:
    """Return the times (n_scans,), seconds, at which the scans' poses are looked up on a trajectory."""
    return seconds(log) + log.trajectory(trajectory).offset_of_stamps(plan.time_offset)


def _are_dense(log: ScanLog, motion: Motion, first: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return whether the poses are dense around sweeps whose first beams are measured at ``first`` (n,), seconds."""
    return motion.is_dense(first, first + log.time_increment * (log.n_beams - 1))


def base_poses(log: ScanLog, plan: UpdatePlan, trajectory: str | None) -> NDArray[np.float64]:
    """Return the robot's pose (n_scans, 3) at each scan's stamp plus the plan's time offset."""
    if log.trajectory(trajectory).offset_of_stamps(plan.time_offset) == 0.0 or log.n_scans == 0:
        return log.trajectory(trajectory).poses
    return Motion.of(log, trajectory).at(_shifted(log, plan, trajectory))


def sensor_poses_of_readings(
    log: ScanLog, plan: UpdatePlan, trajectory: str | None, scans: NDArray[np.int64], beams: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return ``T_map_laser`` (n, 3), mount corrected, of the readings ``beams`` (n,) of ``scans`` (n,).

    A deskewed beam has the pose at its own time, stamp + offset + beam · time_increment, interpolated on the
    trajectory. With ``deskew`` "auto", only the beams of scans with dense poses around their sweep are deskewed
    (:meth:`mapper.sensors.motion.Motion.is_dense`). All others have the pose of their scan.
    """
    if is_deskewed(log, plan, trajectory):
        poses = _poses_of_beams(log, plan, trajectory, scans, beams[:, np.newaxis])[:, 0]
    else:
        poses = base_poses(log, plan, trajectory)[scans]
    return compose(compose(poses, log.mounts_at(scans)), np.array(plan.mount))


def _poses_of_beams(
    log: ScanLog, plan: UpdatePlan, trajectory: str | None, scans: NDArray[np.int64], beams: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return the robot's poses (n, b, 3) at the times of the deskewed ``beams`` (n or 1, b) of ``scans`` (n,)."""
    motion = Motion.of(log, trajectory)
    first = _shifted(log, plan, trajectory)[scans]
    poses = motion.along(first[:, np.newaxis] + log.time_increment * beams)
    if plan.deskew == "auto":
        sparse = ~_are_dense(log, motion, first)
        if sparse.any():
            poses[sparse] = base_poses(log, plan, trajectory)[scans[sparse], np.newaxis]
    return poses


def scan_batches_of_log(
    log: ScanLog, plan: UpdatePlan, trajectory: str | None, start: int, stop: int
) -> Iterator[ScanBatch]:
    """Yield the scans [start, stop) of a log, in parts of bounded memory if they are deskewed."""
    step = max(1, stop - start)
    if is_deskewed(log, plan, trajectory):
        step = max(1, _DESKEWED_READINGS // log.n_beams)
    for first in range(start, stop, step) if start < stop else (start,):
        yield scan_batch_of_log(log, plan, trajectory, first, min(first + step, stop))


def scan_batch_of_log(log: ScanLog, plan: UpdatePlan, trajectory: str | None, start: int, stop: int) -> ScanBatch:
    """Return the scans [start, stop) of a log with the poses of one of its trajectories and the corrected mount.

    Scans whose time, with the offset, is before the first or after the last pose contribute nothing.
    """
    ranges = _covered_ranges(log, plan, trajectory, start, stop)
    if not is_deskewed(log, plan, trajectory):
        poses = compose(base_poses(log, plan, trajectory)[start:stop], log.mounts_at(slice(start, stop)))
        return _batch(log, ranges, compose(poses, np.array(plan.mount)), plan, np.arange(start, stop))
    poses = _poses_of_beams(log, plan, trajectory, np.arange(start, stop), np.arange(log.n_beams)[np.newaxis])
    turns = np.zeros((log.n_beams, 3))
    turns[:, 2] = bearings(log, plan)
    mounts = compose(log.mounts_at(slice(start, stop)), np.array(plan.mount))
    poses = compose(poses, compose(mounts[..., np.newaxis, :], turns))
    ahead = np.zeros(1)
    return ScanBatch(
        _readings(ranges, plan).reshape(-1, 1),
        poses.reshape(-1, 3),
        ahead,
        cones(ahead, plan.cone.opening),
        plan.reading_filter.range_min,
        plan.reading_filter.range_max,
        np.repeat(np.arange(start, stop), log.n_beams),
    )


def scan_batch_of_scan(scan: RangeScan, sensor_pose: NDArray[np.float64], plan: UpdatePlan) -> ScanBatch:
    """Return one scan, taken at ``sensor_pose`` (3,), ``T_map_laser``, with the corrected mount."""
    pose = compose(sensor_pose[np.newaxis], np.array(plan.mount))
    return _batch(scan, scan.ranges[np.newaxis], pose, plan, np.zeros(1, dtype=np.int64))


def _batch(
    sensor: RangeScan | ScanLog,
    ranges: NDArray[np.float32],
    poses: NDArray[np.float64],
    plan: UpdatePlan,
    numbers: NDArray[np.int64],
) -> ScanBatch:
    angles = bearings(sensor, plan)
    fields = _fields(sensor, angles, plan) if plan.sees_fields else _NO_FIELDS
    range_min, range_max = plan.reading_filter.range_min, plan.reading_filter.range_max
    return ScanBatch(_readings(ranges, plan), poses, angles, fields, range_min, range_max, numbers)


def _fields(sensor: RangeScan | ScanLog, angles: NDArray[np.float64], plan: UpdatePlan) -> NDArray[np.float64]:
    """Return the fields (n_beams, 4) of beams at ``angles`` (n_beams,), radians."""
    if plan.strategy.cone and not plan.per_scan:
        return cones(angles, plan.cone.opening)
    widest = plan.cone.opening / 2.0 if plan.strategy.cone else np.pi / 4.0
    if isinstance(sensor, LaserScan):
        sign = -1.0 if plan.upside_down else 1.0
        return _even_fields(sign * sensor.angle_min, sign * sensor.angle_increment, len(angles), widest)
    return sensor.fields(widest, turned_over=plan.upside_down)


@lru_cache(maxsize=32)
def _even_fields(angle_min: float, angle_increment: float, n_beams: int, widest: float) -> NDArray[np.float64]:
    """Return :func:`beam_fields`. The array is shared by all scans of one kind and must not be modified."""
    return beam_fields(angle_min, angle_increment, n_beams, widest)


def bearings(sensor: RangeScan | ScanLog, plan: UpdatePlan) -> NDArray[np.float64]:
    """Return the bearings (n_beams,), radians, with the mount correction applied."""
    return -sensor.angles if plan.upside_down else sensor.angles


def _covered_ranges(
    log: ScanLog, plan: UpdatePlan, trajectory: str | None, start: int, stop: int
) -> NDArray[np.float32]:
    """Return the ranges (stop − start, n_beams), NaN in scans without a known pose (:func:`covered_scans`)."""
    ranges, covered = log.ranges[start:stop], covered_scans(log, plan, trajectory)[start:stop]
    return ranges if covered.all() else np.where(covered[:, np.newaxis], ranges, np.float32(np.nan))


def _readings(ranges: NDArray[np.float32], plan: UpdatePlan) -> NDArray[np.float32]:
    """Return the ranges used for mapping: no return becomes the maximum range if it counts as a hit."""
    if not plan.no_return_is_hit:
        return ranges
    # NumPy compares a float32 with a Python float as two float32, hence the float().
    range_max = plan.reading_filter.range_max
    greatest = np.float32(range_max)
    if float(greatest) > range_max:
        greatest = np.nextafter(greatest, np.float32(0.0))
    return np.where(ranges > greatest, greatest, ranges)


@dataclass(frozen=True, slots=True)
class PosedScan:
    """A scan with the poses (3,) ``T_map_base`` and ``T_map_laser`` from which it was taken.

    Neither pose includes the mount correction of the parameters. For a deskewed scan, ranges and bearings describe the
    beams' endpoints in the map relative to the sensor's pose at the scan's stamp.
    """

    base_pose: NDArray[np.float64]
    sensor_pose: NDArray[np.float64]
    scan: RangeScan


def placed_scan(log: ScanLog, config: MappingConfig, trajectory: str | None, index: int) -> PosedScan:
    """Return scan ``index`` placed in the map by ``config``. Raises :class:`ConfigError` for an unknown trajectory."""
    if isinstance(log, JointLog):
        part = log.parts[int(log.part_of_scan[index])]
        return placed_scan(part, config, trajectory, int(log.scan_of_part[index]))
    plan = plan_update(config, log.range_min, log.range_max)
    scan, base = log.scan(index), base_pose(log, plan, trajectory, index)
    sensor = compose(base, log.mounts_at(index))
    if is_deskewed(log, plan, trajectory):
        ranges, angles = deskewed_beams(log, plan, trajectory, index)
        if plan.upside_down:
            angles = -angles
        scan = SonarScan(ranges, angles, scan.beam_width, scan.range_min, scan.range_max, scan.stamp_ns)
    return PosedScan(base, sensor, scan)


def base_pose(log: ScanLog, plan: UpdatePlan, trajectory: str | None, index: int) -> NDArray[np.float64]:
    """Return the robot's pose (3,) at the stamp of scan ``index`` plus the plan's time offset."""
    offset = log.trajectory(trajectory).offset_of_stamps(plan.time_offset)
    if offset == 0.0:
        return np.asarray(log.trajectory(trajectory).poses[index])
    return np.asarray(Motion.of(log, trajectory).at(seconds(log)[index : index + 1] + offset)[0])


def deskewed_beams(
    log: ScanLog, plan: UpdatePlan, trajectory: str | None, index: int
) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Return range and bearing (n_beams,), metres and radians, of the endpoints of the beams of scan ``index``.

    They are relative to the sensor's pose, mount corrected, at the scan's stamp. Readings that are not a number of
    metres keep their value, in the direction of the sensor at that time.
    """
    beams = np.arange(log.n_beams)
    poses = sensor_poses_of_readings(log, plan, trajectory, np.full(log.n_beams, index), beams)
    base = base_pose(log, plan, trajectory, index)
    here = compose(compose(base, log.mounts_at(index)), np.array(plan.mount))
    x, y, yaw = compose(inverse(here), poses).T
    readings, angles = log.ranges[index].astype(np.float64), yaw + bearings(log, plan)
    measured = np.isfinite(readings)
    reach = np.where(measured, readings, 0.0)
    x, y = x + reach * np.cos(angles), y + reach * np.sin(angles)
    ranges = np.where(measured, np.hypot(x, y), readings).astype(np.float32)
    return ranges, np.where(measured & (reach > 0.0), np.arctan2(y, x), angles)


def without_mount_correction(plan: UpdatePlan) -> UpdatePlan:
    """Return the plan for a sensor mounted as stated in its log."""
    return replace(plan, mount=(0.0, 0.0, 0.0), upside_down=False)
