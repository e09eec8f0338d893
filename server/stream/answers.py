"""Objects in the answers of the HTTP interface whose types the pages generate, as those of messages."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta, Struct

EventKind = Annotated[
    Literal["pushed", "slipped", "lifted", "clock"], Meta(title="EventKind", description="what happened to the robot")
]


class LogEvent(Struct):
    """An event of a log: the robot was moved as its wheels did not measure, or its clock was set."""

    kind: EventKind
    seconds: Annotated[float, Meta(description="begin in recorded time, s")]
    until_s: Annotated[float, Meta(description="end in recorded time, s")]
    time: Annotated[str, Meta(description="begin in recorded time, m:ss.mmm")]
    utc: Annotated[str | None, Meta(description="begin in UTC, ISO 8601; null where the log's clock does not tell it")]
    stamp_ns: Annotated[int | None, Meta(description="begin on the log's clock, ns")]
    scan: Annotated[int, Meta(description="last scan before it, from 0")]
    until_scan: Annotated[int, Meta(description="first scan after it")]
    ahead_m: Annotated[float | None, Meta(description="motion by the scans less that by the wheels: ahead, m")]
    left_m: Annotated[float | None, Meta(description="the same to the left, m")]
    turned_rad: Annotated[float | None, Meta(description="the same, counter-clockwise, rad")]
    distance_m: Annotated[float | None, Meta(description="length of it, m")]
    direction: Annotated[
        Literal["ahead", "behind", "left", "right"] | None, Meta(description="side of the robot to which it went")
    ]
    step_s: Annotated[float, Meta(description="by how much the clock was set, s")]
    sentence: Annotated[str, Meta(description="what happened, in words")]
