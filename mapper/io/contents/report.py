"""Small anonymous excerpt of a log for bug reports: its structure, without its measurements.

It contains types, topics, frames, counts, limits, angles and the notes and the error of reading; for text logs the
shape of their lines. Readings, positions, and names of files, folders, users and machines are not included.
"""

from __future__ import annotations

import contextlib
import getpass
import re
import socket
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from mapper.core.errors import MapperError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.logs import open_robot_log
from mapper.io.logs.archives.unpacking import Unpacked, opened
from mapper.io.logs.containers.container import Container
from mapper.io.logs.names import printable
from mapper.io.logs.opening import parts_of
from mapper.io.logs.recording.sink import MessageSink
from mapper.io.logs.ros.cloud_messages import CLOUD_DECODERS
from mapper.io.logs.ros.message_fields import BadMessageError
from mapper.io.logs.ros.ros_messages import POSES, SENSORS, TRANSFORMS, Beams, StampedPose, plain_type
from mapper.sensors.joint_log import sensors_of
from mapper.sensors.scan import ScanLog

MOST_FIRST = 3  #: described messages of a topic
MOST_TOPICS, MOST_FRAMES, MOST_NOTES = 200, 20, 40
MOST_LINES, MOST_TOKENS = 12, 24  #: text lines with a described shape, and groups of fields of each
HEAD_BYTES = 1 << 16
MAGIC_BYTES = 12
DIGITS = 2  #: significant digits of a limit or of a number in a note, so that none is a reading
SHORTEST_NAME = 3  #: minimum characters of a user, machine or folder name that is removed from notes

Facts = dict[str, Any]


def excerpt(path: Path, limits: Limits = DEFAULT_LIMITS) -> Facts:
    """Return the excerpt of the log at ``path``, plain JSON, even if the log cannot be read."""
    sink = _Excerpt()
    facts: Facts = {"files": _files(path, limits)}
    scrub = _scrubber(path)
    try:
        robot = open_robot_log(path, limits=limits, also=sink)
    except MapperError as error:
        facts["error"] = {"code": error.code, "message": scrub(error.message)}
    else:
        facts["format"] = scrub(robot.first.format)
        facts["sensors"] = [_sensor(log) for log in robot.sensors.values()]
        facts["trajectories"] = [
            {
                "name": name,
                "frame": trajectory.frame_id,
                "child": trajectory.child_frame_id,
                "placeholder": trajectory.is_placeholder,
            }
            for name, trajectory in robot.first.trajectories.items()
        ]
        notes = dict.fromkeys(note for log in robot.sensors.values() for note in log.notes)
        facts["notes"] = [scrub(note) for note in list(notes)[:MOST_NOTES]]
        facts["transforms"] = [
            {
                "parent": edge.parent,
                "child": edge.child,
                "static": edge.is_static,
                "moves": edge.moves,
                "count": edge.count,
            }
            for edge in robot.transforms[:MOST_TOPICS]
        ]
    facts["topics"] = sink.topics()
    return facts


class _Excerpt(MessageSink):
    """Counts the messages of each stream and describes the first few."""

    def __init__(self) -> None:
        self.notes = []
        self._streams: dict[tuple[str, str, bool, bool], Facts] = {}
        self._by_key: dict[int, tuple[Facts, str, bool]] = {}
        self._first_ns: int | None = None

    @property
    def taken(self) -> int:
        """Always 0, because no messages are used."""
        return 0

    def channel(self, key: int, topic: str, kind: str, *, cdr: bool, readable: bool = True) -> None:
        stream = (printable(topic[:200]), printable(plain_type(kind)[:200]), cdr, readable)
        if stream not in self._streams and len(self._streams) >= MOST_TOPICS:
            return
        name, kind, *_ = stream
        serialisation = ("cdr" if cdr else "ros1") if readable else "one that is not read"
        facts = {"topic": name, "type": kind, "serialisation": serialisation, "count": 0, "first": []}
        self._by_key[key] = (self._streams.setdefault(stream, facts), kind, cdr)

    def knows(self, key: int) -> bool:
        return key in self._by_key

    def wants(self, key: int) -> bool:
        return (
            key in self._by_key
            and self._by_key[key][1] in _DESCRIBED
            and len(self._by_key[key][0]["first"]) < MOST_FIRST
        )

    def pass_over(self, key: int, count: int) -> None:
        if key in self._by_key:
            self._by_key[key][0]["count"] += count

    def next_file(self) -> None:
        self._by_key.clear()

    def take(self, key: int, stamp_ns: int, data: bytes, size: int | None = None) -> None:
        if key not in self._by_key:
            return
        facts, kind, cdr = self._by_key[key]
        facts["count"] += 1
        first: list[Facts] = facts["first"]
        if len(first) >= MOST_FIRST:
            return
        self._first_ns = stamp_ns if self._first_ns is None else self._first_ns
        stream_facts: Facts = {
            "bytes": len(data) if size is None else size,
            "recorded_s": round((stamp_ns - self._first_ns) * 1e-9, 3),
        }
        describe = _DESCRIBED.get(kind)
        if describe is not None and data:
            try:
                stream_facts |= describe(kind, data, cdr)
            except BadMessageError as error:
                stream_facts["refused"] = _blurred(str(error)) or "the bytes are no message of this type"
        first.append(stream_facts)

    def topics(self) -> list[Facts]:
        return sorted(self._streams.values(), key=lambda stream: str(stream["topic"]))


def _scan(kind: str, data: bytes, cdr: bool) -> Facts:
    beams: Beams = SENSORS[kind](data, cdr=cdr)
    return {
        "frame": printable(beams.frame[:200]),
        "beams": len(beams.ranges),
        "angle_min": _number(beams.angle_min, 7),
        "angle_increment": _number(beams.angle_increment, 7),
        "range_min": _number(beams.range_min),
        "range_max": _number(beams.range_max),
        "time_increment": _number(beams.time_increment),
        "scan_time": _number(beams.scan_time),
        "beam_width": _number(beams.beam_width),
        "stamped": beams.stamp_ns != 0,
        "readings": _readings(beams.ranges, beams.range_min, beams.range_max),
    }


def _readings(ranges: np.ndarray[Any, np.dtype[np.float32]], range_min: float, range_max: float) -> Facts:
    """Return the numbers of readings by kind, without their values."""
    with np.errstate(invalid="ignore"):
        masks = {
            "measured": (ranges >= range_min) & (ranges <= range_max) & np.isfinite(ranges),
            "beyond_range_max": np.isfinite(ranges) & (ranges > range_max),
            "at_range_max": ranges == np.float32(range_max),
            "below_range_min": np.isfinite(ranges) & (ranges < range_min),
            "zero_or_less": np.isfinite(ranges) & (ranges <= 0.0),
            "+inf": ranges == np.inf,
            "-inf": ranges == -np.inf,
            "nan": np.isnan(ranges),
        }
    return {name: int(np.count_nonzero(mask)) for name, mask in masks.items()}


def _poses(kind: str, data: bytes, cdr: bool) -> Facts:
    stamped: list[StampedPose] = (POSES | TRANSFORMS)[kind](data, cdr=cdr)
    return {
        "poses": len(stamped),
        "frames": [
            {
                "frame": printable(transform.frame[:200]),
                "child": printable(transform.child[:200]),
                "quaternion_length": _number(float(np.linalg.norm(transform.pose[3:])), 4),
                "stamped": transform.stamp_ns != 0,
            }
            for transform in stamped[:MOST_FRAMES]
        ],
    }


def _cloud(kind: str, data: bytes, cdr: bool) -> Facts:
    cloud = CLOUD_DECODERS[kind](data, cdr=cdr)
    height, width = cloud.axes[0].shape
    fields = ["x", "y", "z", *cloud.others]
    return {"frame": printable(cloud.frame[:200]), "points": f"{width} × {height}", "fields": fields[:MOST_FRAMES]}


_DESCRIBED: dict[str, Callable[[str, bytes, bool], Facts]] = {
    **dict.fromkeys(SENSORS, _scan),
    **dict.fromkeys((*POSES, *TRANSFORMS), _poses),
    **dict.fromkeys(CLOUD_DECODERS, _cloud),
}


def _sensor(log: ScanLog) -> Facts:
    first = sensors_of(log)[0]
    return {
        "topic": log.topic,
        "frame": log.frame_id,
        "scans": log.n_scans,
        "parts": [
            {
                "scans": part.n_scans,
                "beams": part.n_beams,
                "angle_min": _number(part.angle_min, 7),
                "angle_increment": _number(part.angle_increment, 7),
                "range_min": _number(part.range_min),
                "range_max": _number(part.range_max),
                "time_increment": _number(part.time_increment),
                "readings": _readings(part.ranges, part.range_min, part.range_max),
            }
            for part in sensors_of(log)
        ],
        "upside_down": first.upside_down,
        "moves_on_the_robot": first.mounts is not None,
    }


def _files(path: Path, limits: Limits) -> list[Facts]:
    """Return a description of the files by size, extension and first bytes; for texts the shape of the first lines."""
    try:
        files, kind = parts_of(path, limits)
    except MapperError:
        files, kind = [path], None
    form = kind.form if isinstance(kind, Container) else None
    entries = []
    for file in list(files)[:MOST_FRAMES]:
        facts: Facts = {"ending": "".join(re.findall(r"\.[a-z0-9]{1,8}", file.name.lower())[-2:]), "format": form}
        try:
            with opened(file) as stream:
                facts["bytes"] = stream.seek(0, 2)
                stream.seek(0)
                unpacked = Unpacked(stream, lambda: "at the beginning", limits)
                head = b""
                for piece in unpacked:
                    head += piece
                    if len(head) >= HEAD_BYTES:
                        break
                facts["packed"] = unpacked.packing
        except (ReadError, OSError):
            facts["unreadable"] = True
            entries.append(facts)
            continue
        head = head[:HEAD_BYTES]
        if b"\0" in head or form is not None:
            facts["begins"] = head[:MAGIC_BYTES].hex(" ")
        else:
            facts["lines"] = _shapes(head)
        entries.append(facts)
    return entries


def _shapes(head: bytes) -> list[str]:
    """Return the distinct shapes of the first lines of a text: which fields are integers, decimals or words."""
    shapes: Counter[str] = Counter()
    for line in head.split(b"\n")[:-1] or [head]:
        shape = _shape(line.decode("latin-1"))
        if shape in shapes or len(shapes) < MOST_LINES:
            shapes[shape] += 1
    return [f"{count} × {shape}" for shape, count in shapes.items()]


def _shape(line: str) -> str:
    groups: list[list[str | int]] = []
    separator = "," if line.count(",") > line.count(" ") else ";" if line.count(";") > line.count(" ") else None
    for token in line.split(separator):
        kind = _kind(token.strip(), is_first=not groups)
        if groups and groups[-1][0] == kind:
            groups[-1][1] = int(groups[-1][1]) + 1
        elif len(groups) < MOST_TOKENS:
            groups.append([kind, 1])
    joint = separator or " "
    return joint.join(f"{kind}×{n}" if int(n) > 1 else str(kind) for kind, n in groups) or "an empty line"


def _kind(token: str, *, is_first: bool) -> str:
    if re.fullmatch(r"[-+]?\d+", token):
        return "int"
    try:
        float(token)
    except ValueError:
        pass
    else:
        return "decimal"
    # The first word of a line identifies it; any other may be a name.
    return token if is_first and re.fullmatch(r"#?[A-Z][A-Z0-9_]{2,29}", token) else "word"


def _number(value: float, digits: int = DIGITS) -> float | str:
    """Return a number with few digits, as a string if JSON lacks it."""
    return float(f"{value:.{digits}g}") if np.isfinite(value) else str(value)


def _blurred(text: str) -> str:
    """Return a sentence with decimals rounded to few digits, without quotes from the file."""
    text = re.sub(r"'[^']*'|\"[^\"]*\"", "'…'", text)
    return re.sub(r"\d+\.\d+(?:e[-+]?\d+)?", lambda match: f"{float(match[0]):.{DIGITS}g}", text)


def _scrubber(path: Path) -> Callable[[str], str]:
    """Return a function that removes names of files, folders, users and machines from a sentence, and rounds its
    numbers.
    """
    whole = path.resolve()
    files = [file.name for file in whole.iterdir()] if whole.is_dir() else []
    names = {str(whole), str(path), whole.name, whole.stem, *files, *whole.parts[1:-1]}
    with contextlib.suppress(OSError, KeyError):  # for a user unknown to the system
        names |= {getpass.getuser(), socket.gethostname()}
    known = sorted((name for name in names if len(name) >= SHORTEST_NAME), key=len, reverse=True)
    pattern = re.compile("|".join(rf"(?<![\w/]){re.escape(name)}(?!\w)" for name in known)) if known else None
    return lambda text: _blurred(pattern.sub("NAME", text) if pattern else text)
