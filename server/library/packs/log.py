"""A robot's log as arrays in one .npz file, from which each sensor is loaded without running the reader again.

No pickle on either side: everything that is not an array of numbers is JSON in an array of bytes. An array that several
sensors share, as the poses of tf, is stored once.
"""

from __future__ import annotations

import json
import uuid
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import MapperError, ReadError
from mapper.sensors.joint_log import JointLog, sensors_of
from mapper.sensors.robot_log import RobotLog, TransformEdge
from mapper.sensors.scan import ScanLog, Topic, Trajectory
from mapper.sensors.timed_poses import OdometryRecords, TimedPoses

VERSION = 7

_ARRAYS = ("ranges", "stamps_ns", "bearings", "mounts", "order_ns")
_APART = ("trajectories", "odometry", "topics", "limits")  #: fields of a log that are neither arrays nor plain JSON

Array = NDArray[Any]
Store = Callable[[Array], int]  #: keeps an array, returns its number
Load = Callable[[int], Array]  #: returns the array of a number


class StalePackError(Exception):
    """The file is no pack of this version: read the log again."""


class NotPackedError(Exception):
    """The pack does not hold the sensor that is asked for."""


def write_pack(log: RobotLog, path: Path) -> None:
    """Write ``log`` to ``path`` atomically: it is there whole, or as it was before."""
    arrays: dict[int, Array] = {}  #: by their ids, in the order of their numbers

    def store(array: Array) -> int:
        arrays.setdefault(id(array), array)
        return list(arrays).index(id(array))

    about = {
        "version": VERSION,
        "topics": [asdict(topic) for topic in log.topics],
        "transforms": [asdict(edge) for edge in log.transforms],
        "sensors": [_described(part, store) for sensor in log.sensors.values() for part in sensors_of(sensor)],
    }
    fresh = path.with_name(f"{path.name}.{uuid.uuid4().hex}.new")
    try:
        with fresh.open("wb") as file:
            stored: dict[str, Any] = {str(number): array for number, array in enumerate(arrays.values())}
            np.savez(file, about=np.frombuffer(json.dumps(about, allow_nan=False).encode(), dtype=np.uint8), **stored)
        fresh.replace(path)
    finally:
        fresh.unlink(missing_ok=True)


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
    about["trajectories"] = [
        {
            "name": name,
            "description": one.description,
            "frame_id": one.frame_id,
            "child_frame_id": one.child_frame_id,
            "is_placeholder": one.is_placeholder,
            "placeholder_note": one.placeholder_note,
            "offset": one.offset,
            "from_scans": one.from_scans,
            "poses": store(one.poses),
            "timed": None if one.timed is None else _timed_described(one.timed, store),
        }
        for name, one in log.trajectories.items()
    ]
    if log.odometry is not None:
        at_scans = log.odometry.at_scans
        about["odometry"] = {
            "messages": _timed_described(log.odometry.messages, store),
            "before_scan": store(log.odometry.before_scan),
            "at_scans": None if at_scans is None else store(at_scans),
        }
    return about


def _timed_described(timed: TimedPoses, store: Store) -> dict[str, Any]:
    return {"stamps_ns": store(timed.stamps_ns), "poses": store(timed.poses), "notes": list(timed.notes)}


def read_pack(path: Path, topic: str | None = None) -> ScanLog:
    """Return one sensor (None: the first) of the log that :func:`write_pack` wrote; only its arrays are read.

    Raises :class:`NotPackedError` for a sensor that the pack lacks, :class:`StalePackError` for any other file or none.
    """
    with _opened(path) as (about, load):
        sensors = about["sensors"]
        name = topic if topic is not None or not sensors else sensors[0]["topic"]
        # A sensor whose scans have different beams has several parts.
        found = [_log_of(one, about["topics"], load) for one in sensors if one["topic"] == name]
        if not found:
            raise NotPackedError(topic)
        return _joined(found)


def read_whole_pack(path: Path) -> ScanLog:
    """Return all sensors of a packed log, in the pack's order, as one log. Raises :class:`StalePackError`."""
    with _opened(path) as (about, load):
        logs = [_log_of(one, about["topics"], load) for one in about["sensors"]]
    return _joined(logs)


def _joined(logs: list[ScanLog]) -> ScanLog:
    return logs[0] if len(logs) == 1 else JointLog.of(logs)


def read_transforms(path: Path) -> tuple[TransformEdge, ...]:
    """Return the tree of frames of a packed log. Raises :class:`StalePackError` as :func:`read_pack`."""
    with _opened(path) as (about, _):
        return tuple(TransformEdge(**edge) for edge in about["transforms"])


@contextmanager
def _opened(path: Path) -> Iterator[tuple[dict[str, Any], Load]]:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            about = json.loads(arrays["about"].tobytes())
            if about["version"] != VERSION:
                raise StalePackError(f"The pack is of version {about['version']}, this is {VERSION}.")
            known: dict[int, Array] = {}

            def load(number: int) -> Array:
                if number not in known:
                    known[number] = arrays[str(number)]
                return known[number]

            yield about, load
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, MapperError) as error:
        raise StalePackError(f"{type(error).__name__}: {error}") from error


def _log_of(about: dict[str, Any], topics: list[dict[str, Any]], load: Load) -> ScanLog:
    values = dict(about)
    chosen = values.pop("chosen")
    for name in _ARRAYS:
        values[name] = None if values[name] is None else load(values[name])
    if values["range_max"] is None:
        values["range_max"] = float("inf")
    odometry = values.pop("odometry", None)
    return ScanLog(
        **values
        | {
            "mount": tuple(values["mount"]),
            "notes": tuple(values["notes"]),
            "topics": tuple(topic_from_json(one | {"chosen": one["name"] in chosen}) for one in topics),
            "trajectories": {
                one["name"]: Trajectory(
                    load(one["poses"]),
                    one["description"],
                    one["frame_id"],
                    one["child_frame_id"],
                    one["is_placeholder"],
                    None if one["timed"] is None else _timed_of(one["timed"], load),
                    tuple(one["offset"]),
                    one["from_scans"],
                    one["placeholder_note"],
                )
                for one in values["trajectories"]
            },
            "odometry": None
            if odometry is None
            else OdometryRecords(
                _timed_of(odometry["messages"], load),
                load(odometry["before_scan"]),
                None if odometry["at_scans"] is None else load(odometry["at_scans"]),
            ),
        }
    )


def _timed_of(about: dict[str, Any], load: Load) -> TimedPoses:
    return TimedPoses(load(about["stamps_ns"]), load(about["poses"]), tuple(about["notes"]))


def topic_from_json(values: dict[str, Any]) -> Topic:
    """Return the topic that ``asdict`` made ``values`` of, also that of an older version, which said more.

    Raises ``TypeError`` for anything else.
    """
    mount = values.get("mount")
    known = {field.name: values[field.name] for field in fields(Topic) if field.name in values}
    return Topic(**(known | {"mount": None if mount is None else tuple(mount)}))


def nbytes(log: ScanLog) -> int:
    """Return how much memory the log's arrays take."""
    timed = [one.timed for one in log.trajectories.values() if one.timed is not None]
    arrays: list[Array | None] = [log.ranges, log.stamps_ns, log.mounts]
    arrays += [one.poses for one in log.trajectories.values()]
    if log.odometry is not None:
        timed.append(log.odometry.messages)
        arrays += [log.odometry.before_scan, log.odometry.at_scans]
    arrays += [array for one in timed for array in (one.stamps_ns, one.poses)]
    return sum({id(array): array.nbytes for array in arrays if array is not None}.values())


def log_in(pack: str) -> ScanLog:
    """Return the log of a job, all sensors that it is to use as one. Raises :class:`ReadError` where it is gone."""
    try:
        return read_whole_pack(Path(pack))
    except StalePackError:
        raise ReadError("log.gone", "What was read of this log is no longer there.") from None
