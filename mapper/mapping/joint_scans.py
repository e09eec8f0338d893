"""Scans of several sensors in time order, in few batches.

Scans are rows of one batch if the sensors' beams are alike, if beams are deskewed, or if beams are thin. Otherwise each
sensor has its own batch, and their scans are drawn in turns (:class:`mapper.mapping.update_plan.Turns`). In each case
the map equals that of integrating the scans one after another, bit for bit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Int64Array
from mapper.grid import GridGeometry
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.scan_batch import ScanBatch, bearings, is_deskewed, scan_batches_of_log, sensor_poses_of_readings
from mapper.mapping.update_plan import Run, Turns, UpdatePlan, plan_update
from mapper.sensors.joint_log import JointLog, scan_order
from mapper.sensors.scan import ScanLog

_READINGS = 1 << 18  # in one batch


@dataclass(frozen=True, slots=True)
class SensorOrder:
    """Scans of several sensors in one order: see :func:`mapper.sensors.joint_log.scan_order`."""

    logs: Sequence[ScanLog]
    part_of_scan: Int64Array
    scan_of_part: Int64Array

    @classmethod
    def of(cls, log: JointLog) -> SensorOrder:
        """Return the order of the scans of a log."""
        return cls(log.parts, log.part_of_scan, log.scan_of_part)

    @classmethod
    def of_logs(cls, logs: Sequence[ScanLog]) -> SensorOrder:
        """Return the order of the scans of several logs."""
        return cls(logs, *scan_order(logs))


@dataclass(frozen=True, slots=True)
class PlannedBatch:
    """Some scans in the form that the updates use, with the plan of their sensors.

    The reading in row r and column c of the batch is beam ``beams[r]`` + c of scan ``scans[r]``.
    """

    batch: ScanBatch
    plan: UpdatePlan
    beams: Int64Array

    @property
    def scans(self) -> Int64Array:
        """The scan index (n_rows,) of each row of the batch."""
        return self.batch.numbers

    def named(self, readings: Int64Array, n_beams: int) -> Int64Array:
        """Return scan · ``n_beams`` + beam for ``readings`` (n,), which are numbered row by row."""
        rows, cols = np.divmod(readings, max(1, self.batch.ranges.shape[1]))
        return np.asarray(self.scans[rows] * n_beams + self.beams[rows] + cols)

    def rows(self, first: int, stop: int) -> PlannedBatch:
        """Return the rows [first, stop)."""
        batch = replace(
            self.batch,
            ranges=self.batch.ranges[first:stop],
            sensor_poses=self.batch.sensor_poses[first:stop],
            numbers=self.batch.numbers[first:stop],
        )
        return PlannedBatch(batch, self.plan, self.beams[first:stop])


def planned_parts(
    order: SensorOrder, config: MappingConfig, trajectory: str | None, start: int, stop: int
) -> Iterator[list[PlannedBatch]]:
    """Yield the scans [start, stop) in parts of bounded memory, at least one part.

    Each part is one batch, or one batch per sensor if their scans cannot be rows of one (see :func:`runs_of`).
    """
    logs = order.logs
    plans = [plan_update(config, log.range_min, log.range_max) for log in logs]
    is_swept = [is_deskewed(log, plan, trajectory) for log, plan in zip(logs, plans, strict=True)]
    step = max(1, _READINGS // max(1, *(log.n_beams for log in logs)))
    edges = [*range(start, stop, step), stop] if start < stop else [start, stop]
    share = _share_batches(logs, plans, is_swept)
    for first, last in pairwise(edges):
        parts = _of_sensors(order, plans, is_swept, trajectory, first, last)
        yield [_interleaved(parts)] if share and len(parts) > 1 else parts


def runs_of(parts: Sequence[PlannedBatch]) -> list[Run]:
    """Return the runs of rows in which the batches of several sensors alternate, in the order of their scans."""
    numbers = np.repeat(np.arange(len(parts)), [len(part.scans) for part in parts])
    # A stable sort keeps the beams of a deskewed scan in order.
    number = numbers[np.argsort(np.concatenate([part.scans for part in parts]), kind="stable")]
    edges = [0, *(np.flatnonzero(np.diff(number)) + 1).tolist(), len(number)]
    done = [0] * len(parts)
    runs = []
    for first, last in pairwise(edges):
        if first < last:
            k = int(number[first])
            runs.append((k, done[k], done[k] + last - first))
            done[k] += last - first
    return runs


def turns_of(parts: Sequence[PlannedBatch], geometry: GridGeometry) -> Turns:
    """Return the scans of several sensors in the form that updates use, on the lattice of ``geometry``."""
    return Turns([(part.batch.scans_on(geometry), part.plan) for part in parts], runs_of(parts))


def _share_batches(logs: Sequence[ScanLog], plans: Sequence[UpdatePlan], is_swept: Sequence[bool]) -> bool:
    """Return whether the scans of all sensors may be rows of one batch."""
    if len({plan.reading_filter.range_max for plan in plans}) > 1 and plans[0].reading_filter.no_return_free:
        return False  # no return means free up to each sensor's own range
    if all(is_swept):
        return True
    if any(is_swept):
        return False
    if all(_alike(logs[0], log) for log in logs):
        return True
    return not (plans[0].sees_fields or plans[0].strategy.statistics == "certainties")


def _alike(a: ScanLog, b: ScanLog) -> bool:
    return a.n_beams == b.n_beams and np.array_equal(a.fields(), b.fields()) and np.array_equal(a.angles, b.angles)


def _of_sensors(
    order: SensorOrder,
    plans: Sequence[UpdatePlan],
    is_swept: Sequence[bool],
    trajectory: str | None,
    start: int,
    stop: int,
) -> list[PlannedBatch]:
    """Return the scans [start, stop), one batch for each sensor that has any, at least one."""
    parts: list[PlannedBatch] = []
    for number in np.unique(order.part_of_scan[start:stop]).tolist() or [0]:
        log, plan = order.logs[number], plans[number]
        scans = start + np.flatnonzero(order.part_of_scan[start:stop] == number)
        first = int(order.scan_of_part[scans[0]]) if len(scans) else 0
        rows_per_scan = log.n_beams if is_swept[number] else 1
        batch = _whole(log, plan, trajectory, first, np.repeat(scans, rows_per_scan), len(scans))
        parts.append(PlannedBatch(batch, plan, np.tile(np.arange(rows_per_scan), len(scans))))
    return parts


def _whole(
    log: ScanLog, plan: UpdatePlan, trajectory: str | None, first: int, numbers: Int64Array, n_scans: int
) -> ScanBatch:
    """Return consecutive scans of one sensor as one batch. ``numbers`` are the indices of its rows."""
    batches = list(scan_batches_of_log(log, plan, trajectory, first, first + n_scans))
    ranges = np.concatenate([batch.ranges for batch in batches])
    poses = np.concatenate([batch.sensor_poses for batch in batches])
    return replace(batches[0], ranges=ranges, sensor_poses=poses, numbers=numbers)


def _interleaved(parts: Sequence[PlannedBatch]) -> PlannedBatch:
    """Merge the rows of several sensors into one batch, in the order of their scans.

    If the beams differ, each sensor has its own columns.
    """
    batches = [part.batch for part in parts]
    first = batches[0]
    same = all(
        np.array_equal(first.angles, batch.angles) and np.array_equal(first.fields, batch.fields) for batch in batches
    )
    columns = (
        [0] * len(batches) if same else np.cumsum([0, *(batch.ranges.shape[1] for batch in batches)])[:-1].tolist()
    )
    width = max(at + batch.ranges.shape[1] for at, batch in zip(columns, batches, strict=True))
    # A stable sort keeps the beams of a deskewed scan in order.
    order = np.argsort(np.concatenate([part.scans for part in parts]), kind="stable")
    ranges = np.full((len(order), width), np.nan, dtype=np.float32)
    row = 0
    for at, part in zip(columns, parts, strict=True):
        own = _measured(part)
        ranges[row : row + len(own), at : at + own.shape[1]] = own
        row += len(own)
    limits = [part.plan.reading_filter for part in parts]
    least, greatest = min(limit.range_min for limit in limits), max(limit.range_max for limit in limits)
    reading_filter = limits[0]._replace(range_min=least, range_max=greatest)
    batch = ScanBatch(
        ranges[order],
        np.concatenate([batch.sensor_poses for batch in batches])[order],
        first.angles if same else np.concatenate([batch.angles for batch in batches]),
        first.fields if same else np.concatenate([batch.fields for batch in batches]),
        least,
        greatest,
        np.concatenate([part.scans for part in parts])[order],
    )
    beams = np.concatenate([part.beams - at for at, part in zip(columns, parts, strict=True)])
    return PlannedBatch(batch, replace(parts[0].plan, reading_filter=reading_filter), beams[order])


def _measured(part: PlannedBatch) -> NDArray[np.float32]:
    """Return the ranges, with NaN for readings outside the limits of their sensor."""
    ranges, limits = part.batch.ranges, part.plan.reading_filter
    metres = ranges.astype(np.float64)
    with np.errstate(invalid="ignore"):
        nothing = metres < limits.range_min
        if not limits.no_return_free:
            nothing |= metres > limits.range_max
    return np.where(nothing, np.float32(np.nan), ranges)


def sensor_poses_of(
    log: ScanLog, config: MappingConfig, trajectory: str | None, scans: Int64Array, beams: Int64Array
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return ``T_map_laser`` (n, 3) and the bearing (n,), radians, of the readings ``beams`` (n,) of ``scans`` (n,).

    The poses are those of :func:`mapper.mapping.scan_batch.sensor_poses_of_readings`, in each sensor's own log.
    """
    if not isinstance(log, JointLog):
        plan = plan_update(config, log.range_min, log.range_max)
        return sensor_poses_of_readings(log, plan, trajectory, scans, beams), bearings(log, plan)[beams]
    order = SensorOrder.of(log)
    poses, angles = np.empty((len(scans), 3)), np.empty(len(scans))
    numbers = order.part_of_scan[scans]
    for number in np.unique(numbers).tolist():
        own, part = numbers == number, order.logs[number]
        plan = plan_update(config, part.range_min, part.range_max)
        poses[own] = sensor_poses_of_readings(part, plan, trajectory, order.scan_of_part[scans[own]], beams[own])
        angles[own] = bearings(part, plan)[beams[own]]
    return poses, angles
