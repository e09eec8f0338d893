"""A robot's log as arrays in one .npz file, from which each sensor is loaded without running the reader again.

It contains no pickles: everything that is not an array of numbers is JSON in an array of bytes. An array that several
sensors share, such as the poses of tf, is stored once.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from mapper.core.errors import ReadError
from mapper.sensors.georeference import Offset
from mapper.sensors.joint_log import JointLog, sensors_of
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog, Topic, Trajectory
from mapper.sensors.timed_poses import OdometryRecords, TimedPoses
from server.library.packs.arrays import UNREADABLE, write_arrays

VERSION = 8

_ARRAYS = ("ranges", "stamps_ns", "bearings", "mounts", "order_ns")
_APART = ("trajectories", "odometry", "topics", "limits")  #: fields of a log that are neither arrays nor plain JSON

Array = NDArray[Any]
Store = Callable[[Array], int]  #: stores an array, returns its number
Load = Callable[[int], Array]  #: returns the array with a number


class _Poses(Struct, frozen=True):
    """Poses with their own stamps; arrays by their numbers."""

    stamps_ns: int
    poses: int
    notes: tuple[str, ...]

    @classmethod
    def of(cls, timed: TimedPoses, store: Store) -> _Poses:
        return cls(store(timed.stamps_ns), store(timed.poses), timed.notes)

    def read(self, load: Load) -> TimedPoses:
        return TimedPoses(load(self.stamps_ns), load(self.poses), self.notes)


class _Trajectory(Struct, frozen=True):
    """A trajectory; arrays by their numbers."""

    name: str
    description: str
    frame_id: str | None
    child_frame_id: str
    is_placeholder: bool
    placeholder_note: str
    offset: Offset
    from_scans: bool
    poses: int
    timed: _Poses | None
    is_known: int | None = None

    @classmethod
    def of(cls, name: str, trajectory: Trajectory, store: Store) -> _Trajectory:
        return cls(
            name=name,
            description=trajectory.description,
            frame_id=trajectory.frame_id,
            child_frame_id=trajectory.child_frame_id,
            is_placeholder=trajectory.is_placeholder,
            placeholder_note=trajectory.placeholder_note,
            offset=trajectory.offset,
            from_scans=trajectory.from_scans,
            poses=store(trajectory.poses),
            timed=None if trajectory.timed is None else _Poses.of(trajectory.timed, store),
            is_known=None if trajectory.is_known is None else store(trajectory.is_known),
        )

    def read(self, load: Load) -> Trajectory:
        return Trajectory(
            poses=load(self.poses),
            description=self.description,
            frame_id=self.frame_id,
            child_frame_id=self.child_frame_id,
            is_placeholder=self.is_placeholder,
            timed=None if self.timed is None else self.timed.read(load),
            offset=self.offset,
            from_scans=self.from_scans,
            placeholder_note=self.placeholder_note,
            is_known=None if self.is_known is None else load(self.is_known),
        )


class _Odometry(Struct, frozen=True):
    """The odometry as recorded; arrays by their numbers."""

    messages: _Poses
    before_scan: int
    at_scans: int | None

    @classmethod
    def of(cls, odometry: OdometryRecords, store: Store) -> _Odometry:
        return cls(
            messages=_Poses.of(odometry.messages, store),
            before_scan=store(odometry.before_scan),
            at_scans=None if odometry.at_scans is None else store(odometry.at_scans),
        )

    def read(self, load: Load) -> OdometryRecords:
        at_scans = None if self.at_scans is None else load(self.at_scans)
        return OdometryRecords(self.messages.read(load), load(self.before_scan), at_scans)


class _About(Struct, frozen=True):
    """The contents of a pack besides arrays.

    ``sensors`` have the fields of :class:`ScanLog` by name, so that a new field of numbers or text is stored too.
    """

    version: int
    topics: tuple[Topic, ...]
    sensors: list[dict[str, Any]]


class StalePackError(Exception):
    """The file is not a pack of this version, so the log must be read again."""


class NotPackedError(Exception):
    """The pack does not contain the requested sensor."""


def write_pack(log: RobotLog, path: Path) -> None:
    """Write ``log`` to ``path`` atomically: it is complete, or as it was before."""
    arrays: dict[int, Array] = {}  #: by their ids, in the order of their numbers

    def store(array: Array) -> int:
        arrays.setdefault(id(array), array)
        return list(arrays).index(id(array))

    about = _About(
        version=VERSION,
        topics=log.topics,
        sensors=[_described(part, store) for sensor in log.sensors.values() for part in sensors_of(sensor)],
    )
    stored = {str(number): array for number, array in enumerate(arrays.values())}
    write_arrays(path, json.dumps(about, allow_nan=False, default=msgspec.to_builtins), stored)


def _described(log: ScanLog, store: Store) -> dict[str, Any]:
    about: dict[str, Any] = {}
    for field in fields(log):
        value = getattr(log, field.name)
        if field.name in _ARRAYS:
            about[field.name] = None if value is None else store(value)
        elif field.name not in _APART:
            about[field.name] = value
    about["range_max"] = float(log.range_max) if np.isfinite(log.range_max) else None
    about["chosen"] = [topic.name for topic in log.topics if topic.chosen]
    about["trajectories"] = [_Trajectory.of(name, trajectory, store) for name, trajectory in log.trajectories.items()]
    if log.odometry is not None:
        about["odometry"] = _Odometry.of(log.odometry, store)
    return about


def read_pack(path: Path, topic: str | None = None) -> ScanLog:
    """Return one sensor (None: the first) of the log that :func:`write_pack` wrote; only its arrays are read.

    Raises :class:`NotPackedError` if the pack does not contain the sensor, :class:`StalePackError` for any other file
    or none.
    """
    with _opened(path) as (about, load):
        sensors = about.sensors
        name = topic if topic is not None or not sensors else sensors[0]["topic"]
        # A sensor whose scans have different beams has several parts.
        logs = [_log_of(sensor, about.topics, load) for sensor in sensors if sensor["topic"] == name]
        if not logs:
            raise NotPackedError(topic)
        return _joined(logs)


def read_whole_pack(path: Path) -> ScanLog:
    """Return all sensors of a packed log, in the pack's order, as one log. Raises :class:`StalePackError`."""
    with _opened(path) as (about, load):
        logs = [_log_of(sensor, about.topics, load) for sensor in about.sensors]
    return _joined(logs)


def _joined(logs: list[ScanLog]) -> ScanLog:
    return logs[0] if len(logs) == 1 else JointLog.of(logs)


@contextmanager
def _opened(path: Path) -> Iterator[tuple[_About, Load]]:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            about = msgspec.json.decode(arrays["about"].tobytes(), type=_About)
            if about.version != VERSION:
                raise StalePackError(f"The pack is of version {about.version}, this is {VERSION}.")
            known: dict[int, Array] = {}

            def load(number: int) -> Array:
                if number not in known:
                    known[number] = arrays[str(number)]
                return known[number]

            yield about, load
    except UNREADABLE as error:
        raise StalePackError(f"{type(error).__name__}: {error}") from error


def _log_of(about: dict[str, Any], topics: Sequence[Topic], load: Load) -> ScanLog:
    values = dict(about)
    chosen = values.pop("chosen")
    for name in _ARRAYS:
        values[name] = None if values[name] is None else load(values[name])
    if values["range_max"] is None:
        values["range_max"] = float("inf")
    values["mount"], values["notes"] = tuple(values["mount"]), tuple(values["notes"])
    values["topics"] = tuple(replace(topic, chosen=topic.name in chosen) for topic in topics)
    trajectories = msgspec.convert(values["trajectories"], list[_Trajectory])
    values["trajectories"] = {trajectory.name: trajectory.read(load) for trajectory in trajectories}
    if "odometry" in values:
        values["odometry"] = msgspec.convert(values["odometry"], _Odometry).read(load)
    return ScanLog(**values)


def nbytes(log: ScanLog) -> int:
    """Return the memory used by the log's arrays, bytes."""
    timed = [trajectory.timed for trajectory in log.trajectories.values() if trajectory.timed is not None]
    arrays: list[Array | None] = [log.ranges, log.stamps_ns, log.mounts]
    arrays += [trajectory.poses for trajectory in log.trajectories.values()]
    if log.odometry is not None:
        timed.append(log.odometry.messages)
        arrays += [log.odometry.before_scan, log.odometry.at_scans]
    arrays += [array for poses in timed for array in (poses.stamps_ns, poses.poses)]
    return sum({id(array): array.nbytes for array in arrays if array is not None}.values())


def log_in(pack: str) -> ScanLog:
    """Return the log of a job, with all sensors to use as one. Raises :class:`ReadError` if it is missing."""
    try:
        return read_whole_pack(Path(pack))
    except StalePackError:
        raise ReadError("log.gone", "What was read of this log is no longer there.") from None
