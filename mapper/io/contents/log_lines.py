"""Log lines of ROS nodes: messages of /rosout, and state changes on /diagnostics.

Source: the definitions of rcl_interfaces/Log, rosgraph_msgs/Log, foxglove_msgs/Log and diagnostic_msgs/DiagnosticArray.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

from mapper.io.logs.names import printable
from mapper.io.logs.ros.message_fields import MessageFields

DEBUG, INFO, WARN, ERROR, FATAL = 10, 20, 30, 40, 50  #: levels, as in rcl_interfaces/Log
#: Levels of rosgraph_msgs/Log, of foxglove_msgs/Log, and of diagnostic_msgs/DiagnosticStatus, whose last is "stale".
_ROS1 = {1: DEBUG, 2: INFO, 4: WARN, 8: ERROR, 16: FATAL}
_FOXGLOVE = {1: DEBUG, 2: INFO, 3: WARN, 4: ERROR, 5: FATAL}
_DIAGNOSTIC = {0: INFO, 1: WARN, 2: ERROR, 3: WARN}
MAX_LINES = 10_000  #: lines stored below WARN, and as many from WARN on
MAX_TEXT, MAX_NAME = 1000, 200  #: stored characters of a line
MAX_STATES = 10_000  #: states on /diagnostics whose changes are tracked
_COLOURS = re.compile(r"\x1b\[[0-9;]*[A-Za-z]")  # written by nodes for a terminal


@dataclass(frozen=True, slots=True)
class LogLine:
    """A line logged by a node, with ``level`` :data:`DEBUG` to :data:`FATAL`.

    ``stamp_ns`` is the time stated by the message or, if it states none (``is_recorded``), its recording time.
    """

    stamp_ns: int
    is_recorded: bool
    level: int
    topic: str
    name: str
    text: str


_Stated = tuple[int, int, str, str]  #: stamp, ns, 0 for none; level; name; text


def _log_of_ros2(fields: MessageFields) -> list[_Stated]:
    stamp = _stamp(fields)
    level = int(fields.unpack("B", 1)[0])
    name, text = fields.string(), fields.string()
    return [(stamp, level, name, text)]


def _log_of_ros1(fields: MessageFields) -> list[_Stated]:
    stamp, _ = fields.header()
    level = int(fields.unpack("B", 1)[0])
    name, text = fields.string(), fields.string()
    return [(stamp, _ROS1.get(level, INFO), name, text)]


def _log_of_foxglove(fields: MessageFields) -> list[_Stated]:
    stamp = _stamp(fields)
    level = int(fields.unpack("B", 1)[0])
    text, name = fields.string(), fields.string()
    return [(stamp, _FOXGLOVE.get(level, INFO), name, text)]


def _diagnostics(fields: MessageFields) -> list[_Stated]:
    stamp, _ = fields.header()
    stated = []
    for _ in range(fields.count(1)):
        level = int(fields.unpack("B", 1)[0])
        name, text = fields.string(), fields.string()
        fields.string()  # hardware id
        for _ in range(fields.count(8)):
            fields.string()
            fields.string()
        stated.append((stamp, _DIAGNOSTIC.get(level, ERROR), name, text or _STATES.get(level, "")))
    return stated


_STATES = {0: "OK", 1: "Warning", 2: "Error", 3: "Stale"}


def _stamp(fields: MessageFields) -> int:
    seconds, nanoseconds = fields.unpack("i" if fields.cdr else "I", 4)[0], fields.unpack("I", 4)[0]
    return int(seconds) * 1_000_000_000 + int(nanoseconds)


_READ: dict[str, Callable[[MessageFields], list[_Stated]]] = {
    "rcl_interfaces/Log": _log_of_ros2,
    "rosgraph_msgs/Log": _log_of_ros1,
    "foxglove_msgs/Log": _log_of_foxglove,
    "diagnostic_msgs/DiagnosticArray": _diagnostics,
}
LOGGED = frozenset(_READ)  #: types whose messages have lines


class LineReader:
    """Processes the messages of :data:`LOGGED`, and stores a limited number of lines.

    The first :data:`MAX_LINES` lines below warning level are stored, and as many from it on, so that a verbose node
    does not displace errors. Of a state published repeatedly without change, the first message is stored.
    """

    def __init__(self) -> None:
        self.left_out = 0
        self._kept: tuple[list[LogLine], list[LogLine]] = ([], [])
        self._states: dict[tuple[str, str], tuple[int, str]] = {}

    @property
    def lines(self) -> list[LogLine]:
        """The lines so far, in time order."""
        return sorted((line for kept in self._kept for line in kept), key=lambda line: line.stamp_ns)

    def take(self, kind: str, topic: str, stamp_ns: int, data: bytes, *, cdr: bool) -> None:
        """Process one message, recorded at ``stamp_ns``. Raises ``BadMessageError``."""
        read = _READ[kind]
        for stated, level, whole_name, whole_text in read(MessageFields(data, cdr=cdr)):
            name, text = printable(whole_name[:MAX_NAME]), _legible(whole_text)
            if read is _diagnostics and not self._is_new(topic, name, level, text):
                continue
            lines = self._kept[level >= WARN]
            if len(lines) >= MAX_LINES:
                self.left_out += 1
                continue
            is_recorded = not 0 < stated < 1 << 62
            lines.append(LogLine(stamp_ns if is_recorded else stated, is_recorded, level, topic, name, text))

    def _is_new(self, topic: str, name: str, level: int, text: str) -> bool:
        if self._states.get((topic, name)) == (level, text):
            return False
        if (topic, name) in self._states or len(self._states) < MAX_STATES:
            self._states[topic, name] = (level, text)
        return True


def _legible(text: str) -> str:
    """Return a text on one line without colours, cut at :data:`MAX_TEXT` characters."""
    plain = " ".join(_COLOURS.sub("", text[: 2 * MAX_TEXT]).split())
    return printable(plain if len(plain) <= MAX_TEXT else f"{plain[:MAX_TEXT]} …")
