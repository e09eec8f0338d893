"""The contents of a recording: its topics, its transforms over time, and the series of numbers for plots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.io.contents.log_lines import LogLine
from mapper.io.logs.ros.message_fields import Pose7
from mapper.sensors.camera import Intrinsics

Int64Array = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class TopicContents:
    """The messages of one topic and type. ``first_ns`` and ``last_ns`` are the earliest and latest time of recording.

    Both are 0 for messages without a time. ``bytes`` are those of the messages as they are serialised, without the
    container's own.
    """

    name: str
    type: str
    messages: int
    bytes: int
    first_ns: int
    last_ns: int

    @property
    def span_s(self) -> float:
        """Seconds from the first message to the last."""
        return (self.last_ns - self.first_ns) * 1e-9

    @property
    def rate_hz(self) -> float | None:
        """Messages a second, on average over the span; None for fewer than two, or for messages without times."""
        return (self.messages - 1) / self.span_s if self.messages > 1 and self.span_s > 0.0 else None


@dataclass(frozen=True, slots=True)
class FrameEdge:
    """The transforms from ``child`` to ``parent`` on a topic: the times that they state, ascending, (n,) int64 ns.

    ``is_static`` where they were published on a topic of static transforms: such a transform is valid at all times.
    ``pose`` is the last that was recorded, ``T_parent_child``: x, y, z, metres, and the quaternion x, y, z, w.
    """

    parent: str
    child: str
    is_static: bool
    stamps_ns: Int64Array
    topic: str = "/tf"
    pose: Pose7 = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        if self.stamps_ns.ndim != 1 or len(self.stamps_ns) == 0 or (np.diff(self.stamps_ns) < 0).any():
            raise ConfigError("contents.stamps", "An edge needs at least one time, and its times must ascend.")

    @property
    def rate_hz(self) -> float | None:
        """Transforms a second, on average; None for fewer than two."""
        span = (int(self.stamps_ns[-1]) - int(self.stamps_ns[0])) * 1e-9
        return (len(self.stamps_ns) - 1) / span if span > 0.0 else None

    def age_s(self, at_ns: int) -> float | None:
        """Seconds since the newest transform that is not later than ``at_ns``; None before the first.

        Of a static edge 0: tf2 takes it as valid at all times.
        """
        if self.is_static:
            return 0.0
        index = int(np.searchsorted(self.stamps_ns, at_ns, side="right")) - 1
        return None if index < 0 else (at_ns - int(self.stamps_ns[index])) * 1e-9


@dataclass(frozen=True, slots=True)
class CameraContents:
    """What the CameraInfo on ``topic`` states first: the optical ``frame`` of the camera, and its intrinsics."""

    topic: str
    frame: str
    intrinsics: Intrinsics


@dataclass(frozen=True, slots=True)
class Column:
    """One number of a message over time: its label, its unit, and the plot that it is drawn in."""

    label: str
    unit: str
    plot: str


@dataclass(frozen=True, slots=True)
class Series:
    """The numbers of one topic: ``values`` (n, columns) at ``stamps_ns`` (n,), ascending.

    The stamps are those that messages state; with ``recorded`` those of their recording, where they state none.
    """

    topic: str
    type: str
    columns: tuple[Column, ...]
    stamps_ns: Int64Array
    values: NDArray[np.floating[Any]]
    recorded: bool = False

    def __post_init__(self) -> None:
        if self.values.shape != (len(self.stamps_ns), len(self.columns)):
            raise ConfigError(
                "contents.series",
                f"A series of {len(self.stamps_ns)} times and {len(self.columns)} columns cannot have values of "
                f"shape {self.values.shape}.",
            )


@dataclass(frozen=True, slots=True)
class Contents:
    """Contents of a recording. ``notes`` state what could not be read.

    ``lines`` are what nodes logged, ascending in time, and ``lines_left_out`` the number of those beyond the limit.
    """

    topics: tuple[TopicContents, ...]
    edges: tuple[FrameEdge, ...] = ()
    series: tuple[Series, ...] = ()
    notes: tuple[str, ...] = ()
    lines: tuple[LogLine, ...] = ()
    lines_left_out: int = 0
    cameras: tuple[CameraContents, ...] = ()
