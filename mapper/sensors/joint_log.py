"""Scans of several sensors of one robot in time order, as one log."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Int64Array
from mapper.core.errors import ConfigError
from mapper.sensors.scan import RangeScan, ScanLog, Trajectory

SEPARATOR = " + "  #: between the topics of several sensors in the name of their joint log


def ascending_times(stamps_ns: Int64Array, counted_ns: Int64Array | None = None) -> Int64Array | None:
    """Return ascending times (n,), each at or after its scan's stamp; None if the stamps already ascend.

    ``counted_ns`` (n,) are the stamps continued across restarts of the recording's clock.
    """
    numbers = np.arange(len(stamps_ns))
    times = np.maximum.accumulate((stamps_ns if counted_ns is None else counted_ns) - numbers) + numbers
    return None if np.array_equal(times, stamps_ns) else np.asarray(times)


def scan_order(logs: Sequence[ScanLog]) -> tuple[Int64Array, Int64Array]:
    """Return, for all scans of the logs ordered by stamp, the log of each scan and its index in it, (n,).

    Within a log the file's order is kept, even if time runs backwards; for equal stamps the first log comes first. If a
    log has ``order_ns``, these times are used instead of the stamps.
    """
    stamps = [np.maximum.accumulate(log.stamps_ns if log.order_ns is None else log.order_ns) for log in logs]
    numbers = np.repeat(np.arange(len(logs)), [log.n_scans for log in logs])
    indices = np.concatenate([np.arange(log.n_scans) for log in logs])
    order = np.argsort(np.concatenate(stamps), kind="stable")
    return numbers[order], indices[order]


@dataclass(frozen=True, slots=True)
class JointLog(ScanLog):
    """One log of several planar sensors, with their scans in the order of their stamps.

    ``parts`` are the sensors' own logs. Scan t is the scan ``scan_of_part[t]`` of the part ``part_of_scan[t]``, both
    (n_scans,) int64. ``ranges`` (n_scans, n_beams) has as many columns as the sensor with most beams, NaN in the
    columns that a scan's sensor lacks. Trajectories are those that all parts have, in one frame. Other sensor
    properties — mount, bearings, times between beams — are those of the first part here; each part has its own.
    """

    parts: tuple[ScanLog, ...] = ()
    part_of_scan: Int64Array = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    scan_of_part: Int64Array = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def __post_init__(self) -> None:
        # super() without arguments does not work in a class with slots.
        ScanLog.__post_init__(self)
        # A trajectory added to this log or replaced in it also applies to each part.
        parts = []
        for number, part in enumerate(self.parts):
            own = self.part_of_scan == number
            changed = {
                name: trajectory.take(own)
                for name, trajectory in self.trajectories.items()
                if name not in part.trajectories
                or not np.array_equal(part.trajectories[name].known_poses, trajectory.known_poses[own], equal_nan=True)
            }
            parts.append(replace(part, trajectories={**part.trajectories, **changed}) if changed else part)
        object.__setattr__(self, "parts", tuple(parts))

    @classmethod
    def of(cls, logs: Sequence[ScanLog]) -> JointLog:
        """Return the joint log of several sensors, or of one sensor whose scans have different beams, in parts of one
        topic.

        Raises :class:`ConfigError` for sonars mixed with lidars, and if no trajectory is common to all sensors.
        """
        if len({log.beam_width > 0.0 for log in logs}) > 1:
            raise ConfigError(
                "log.sensors", "Sonars and lidars need different models: map each by itself, and merge the maps."
            )
        logs = [part for log in logs for part in sensors_of(log)]
        first = logs[0]
        part_of_scan, scan_of_part = scan_order(logs)
        ranges = np.full((len(part_of_scan), max(log.n_beams for log in logs)), np.nan, dtype=np.float32)
        stamps = np.empty(len(part_of_scan), dtype=np.int64)
        for number, log in enumerate(logs):
            own = part_of_scan == number
            ranges[own, : log.n_beams] = log.ranges
            stamps[own] = log.stamps_ns
        trajectories = {
            name: _joined([log.trajectories[name] for log in logs], part_of_scan)
            for name in first.trajectories
            if _is_common(name, logs)
        }
        if not trajectories:
            raise ConfigError(
                "log.frames", "These sensors have no trajectory of one name, in one frame: map each by itself."
            )
        bearings = first.bearings
        if bearings is not None:
            bearings = np.pad(bearings, (0, ranges.shape[1] - len(bearings)))
        notes = dict.fromkeys([*(note for log in logs for note in log.notes), *_notes_on_clocks(logs)])
        return cls(
            **{name: getattr(first, name) for name in ScanLog.__dataclass_fields__}
            | {
                "ranges": ranges,
                "stamps_ns": stamps,
                "trajectories": trajectories,
                "bearings": bearings,
                "range_min": min(log.range_min for log in logs),
                "range_max": max(log.range_max for log in logs),
                "topic": SEPARATOR.join(dict.fromkeys(log.topic for log in logs)),
                "notes": tuple(notes),
                "angles_assumed": any(log.angles_assumed for log in logs),
                "mount_assumed": any(log.mount_assumed for log in logs),
                "odometry": None,
                "mounts": None,
                "order_ns": None,
            },
            parts=tuple(logs),
            part_of_scan=part_of_scan,
            scan_of_part=scan_of_part,
        )

    def take(self, scans: NDArray[np.bool_] | NDArray[np.int64] | slice) -> ScanLog:
        """Return the log of some of the scans, in the order of this log."""
        chosen = np.zeros(self.n_scans, dtype=np.bool_)
        chosen[scans] = True
        return JointLog.of(
            [
                part.take(np.sort(self.scan_of_part[chosen & (self.part_of_scan == k)]))
                for k, part in enumerate(self.parts)
            ]
        )

    def scan(self, index: int) -> RangeScan:
        """Return scan ``index`` as in its sensor's log."""
        part = self.parts[int(self.part_of_scan[index])]
        return part.scan(int(self.scan_of_part[index]))

    def mount_of(self, index: int) -> NDArray[np.float64]:
        """Return ``T_base_laser`` (3,) of the sensor of scan ``index``, at that scan."""
        part = self.parts[int(self.part_of_scan[index])]
        return part.mount_of(int(self.scan_of_part[index]))

    def can_deskew(self, trajectory: str | None = None) -> bool:
        """Return whether the scans of any sensor can be deskewed, according to its own log."""
        return any(part.can_deskew(trajectory) for part in self.parts)

    def sensor_poses(self, trajectory: str | None = None) -> NDArray[np.float64]:
        """Return ``T_map_laser`` of every scan (n_scans, 3), each with its own sensor."""
        poses = np.empty((self.n_scans, 3))
        for number, part in enumerate(self.parts):
            poses[self.part_of_scan == number] = part.sensor_poses(trajectory)
        return poses


def sensors_of(log: ScanLog) -> tuple[ScanLog, ...]:
    """Return the logs of a log's sensors: its parts, or itself."""
    return log.parts if isinstance(log, JointLog) else (log,)


def sensor_numbers(parts: Sequence[ScanLog]) -> Int64Array:
    """Return the sensor number of each part, in the order of first occurrence.

    Parts with one topic and frame are one sensor, whose scans have different beams or limits.
    """
    known: dict[tuple[str, str] | int, int] = {}
    names = [(part.topic, part.frame_id) if part.topic else number for number, part in enumerate(parts)]
    return np.array([known.setdefault(name, len(known)) for name in names], dtype=np.int64)


def by_sensor(log: ScanLog) -> list[tuple[ScanLog, Int64Array]]:
    """Return the log of each sensor of a log (:func:`sensor_numbers`), and the indices of its scans in the log."""
    if not isinstance(log, JointLog):
        return [(log, np.arange(log.n_scans))]
    of_part = sensor_numbers(log.parts)
    sensors = []
    for number in range(of_part.max() + 1):
        numbers = np.flatnonzero(of_part == number)
        parts = [log.parts[k] for k in numbers.tolist()]
        sensor = parts[0] if len(parts) == 1 else log if len(parts) == len(log.parts) else JointLog.of(parts)
        sensors.append((sensor, np.flatnonzero(np.isin(log.part_of_scan, numbers))))
    return sensors


def each_part(log: ScanLog, changed: Callable[[ScanLog], ScanLog]) -> ScanLog:
    """Return a log with ``changed``, which must keep the scans, applied to each of its parts, or to the log itself."""
    return JointLog.of([changed(part) for part in log.parts]) if isinstance(log, JointLog) else changed(log)


def with_trajectories(log: ScanLog, trajectories: Mapping[str, Trajectory]) -> ScanLog:
    """Return a log, and its parts, with only these trajectories and without odometry."""
    if not isinstance(log, JointLog):
        return replace(log, trajectories=trajectories, odometry=None)
    owners = [log.part_of_scan == number for number in range(len(log.parts))]
    return JointLog.of(
        [
            replace(
                part,
                trajectories={name: trajectory.take(own) for name, trajectory in trajectories.items()},
                odometry=None,
            )
            for part, own in zip(log.parts, owners, strict=True)
        ]
    )


def is_measured(log: ScanLog) -> NDArray[np.bool_]:
    """Return which readings (n_scans, n_beams) are measured ranges, by the limits of their sensor.

    An infinite reading is no return, for a sensor without a maximum range as well.
    """
    least, greatest = (
        np.array([getattr(part, name) for part in sensors_of(log)])[part_of_scan(log), np.newaxis]
        for name in ("range_min", "range_max")
    )
    return np.asarray((log.ranges >= least) & (log.ranges <= greatest) & np.isfinite(log.ranges))


def with_notes(log: ScanLog, notes: Sequence[str], *, first: bool = False) -> ScanLog:
    """Return a log with additional notes, after its own or, with ``first``, before them; also in a joint log's first
    part.
    """
    if not notes:
        return log
    both = (*notes, *log.notes) if first else (*log.notes, *notes)
    if not isinstance(log, JointLog):
        return replace(log, notes=both)
    return replace(log, notes=both, parts=(with_notes(log.parts[0], notes, first=first), *log.parts[1:]))


def without_notes(log: ScanLog, notes: Sequence[str]) -> ScanLog:
    """Return a log without these notes; also in a joint log's parts."""
    other_notes = tuple(note for note in log.notes if note not in notes)
    if not isinstance(log, JointLog):
        return replace(log, notes=other_notes)
    return replace(log, notes=other_notes, parts=tuple(without_notes(part, notes) for part in log.parts))


def part_of_scan(log: ScanLog) -> Int64Array:
    """Return the index in :func:`sensors_of` of each scan (n_scans,)."""
    return log.part_of_scan if isinstance(log, JointLog) else np.zeros(log.n_scans, dtype=np.int64)


def sensor_of_scan(log: ScanLog) -> Int64Array:
    """Return the sensor number (:func:`sensor_numbers`) of each scan (n_scans,)."""
    return sensor_numbers(sensors_of(log))[part_of_scan(log)]


def _notes_on_clocks(logs: Sequence[ScanLog]) -> list[str]:
    """Return a note if the stamps of the sensors do not overlap, as with different clocks."""
    spans = [(int(log.stamps_ns.min()), int(log.stamps_ns.max()), log.topic) for log in logs if log.n_scans]
    first = min(spans, key=lambda span: span[1], default=None)
    late = [name for start, _, name in spans if first is not None and start > first[1] and name != first[2]]
    if first is None or not late:
        return []
    note = (
        f"All scans of {', '.join(late)} are later than those of {first[2]}, so they are mapped after them: either the "
        "sensors were not recorded together, or their clocks differ."
    )
    return [note]


def _is_common(name: str, logs: Sequence[ScanLog]) -> bool:
    """Return whether all logs have a trajectory of this name in one frame, ignoring the frames of placeholders."""
    trajectories = [log.trajectories.get(name) for log in logs]
    known = [trajectory for trajectory in trajectories if trajectory is not None]
    frames = {trajectory.frame_id for trajectory in known if not trajectory.is_placeholder}
    return len(known) == len(trajectories) and len(frames) < 2


def _joined(trajectories: Sequence[Trajectory], part_of_scan: Int64Array) -> Trajectory:
    poses, known = np.empty((len(part_of_scan), 3)), np.ones(len(part_of_scan), dtype=np.bool_)
    for number, trajectory in enumerate(trajectories):
        own = part_of_scan == number
        poses[own] = trajectory.poses
        if trajectory.is_known is not None:
            known[own] = trajectory.is_known
    return replace(trajectories[0], poses=poses, is_known=None if known.all() else known)
