"""An event of a log as the HTTP interface answers it, and as the result of a job keeps it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from mapper.diagnosis.events import Event


@dataclass(frozen=True, slots=True)
class LogEvent:
    """An event of a log: the robot was moved as its wheels did not measure, its clock was set, or nothing recorded.

    ``seconds`` and ``until_s`` are its begin and end in recorded time, ``time`` the begin as m:ss.mmm, ``utc`` that in
    UTC, ISO 8601, null where the log's clock does not tell it, and ``stamp_ns`` on the log's clock. ``scan`` is the
    last scan before it, from 0, ``until_scan`` the first one after it. ``ahead_m``, ``left_m`` and ``turned_rad``, the
    latter counter-clockwise, are the motion by the scans less that by the wheels, ``distance_m`` its length and
    ``direction`` the side of the robot to which it went. ``step_s`` is by how much the clock was set, ``moved_m`` how
    far the robot came in a gap by its poses, null where they do not tell. ``sentence`` says in words when and what
    happened, ``what`` the same without the time, with which the sentence begins.
    """

    kind: Literal["pushed", "slipped", "lifted", "clock", "gap"]
    seconds: float
    until_s: float
    time: str
    utc: str | None
    stamp_ns: int | None
    scan: int
    until_scan: int
    ahead_m: float | None
    left_m: float | None
    turned_rad: float | None
    distance_m: float | None
    direction: Literal["ahead", "behind", "left", "right"] | None
    step_s: float
    moved_m: float | None
    sentence: str
    what: str


def log_events(events: Iterable[Event]) -> tuple[LogEvent, ...]:
    """Return events as they are answered."""
    return tuple(LogEvent(**event.public()) for event in events)
