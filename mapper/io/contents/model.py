"""Contents of a recording: its topics, its transforms over time, and the series of numbers for plots."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.errors import ConfigError
from mapper.io.contents.log_lines import LogLine
from mapper.io.logs.recording.poses3 import interpolated, poses_of
from mapper.io.logs.ros.message_fields import Pose7
from mapper.sensors.camera import Intrinsics, Lens

#: The message types that can be shown as pictures (:mod:`mapper.io.contents.pictures`).
CAMERAS = frozenset({"sensor_msgs/Image", "sensor_msgs/CompressedImage"})
PICTURED = CAMERAS | {"sensor_msgs/PointCloud2"}


@dataclass(frozen=True, slots=True)
class TopicContents:
    """The messages of one topic and type. ``first_ns`` and ``last_ns`` are the earliest and latest recording times.

    Both are 0 for messages without a time. ``bytes`` is the total size of the serialised messages, without the
    container's overhead.
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
        """Mean number of messages per second over the span; None for fewer than two, or for messages without times."""
        return (self.messages - 1) / self.span_s if self.messages > 1 and self.span_s > 0.0 else None


@dataclass(frozen=True, slots=True)
class FrameEdge:
    """The transforms from ``child`` to ``parent`` on a topic: their stated times, ascending, (n,) int64 ns.

    ``is_static`` if they were published on a topic of static transforms, which are valid at all times. ``pose`` is the
    last recorded one, ``T_parent_child``: x, y, z, metres, and the quaternion x, y, z, w. For a moving one, ``poses``
    (m, 7) are those at ``pose_stamps_ns`` (m,), ascending; in a long recording not all of them. ``publishers`` are the
    nodes that published it, if recorded.
    """

    parent: str
    child: str
    is_static: bool
    stamps_ns: Int64Array
    topic: str = "/tf"
    pose: Pose7 = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    pose_stamps_ns: Int64Array = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    poses: Float64Array = field(default_factory=lambda: np.zeros((0, 7)))
    publishers: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.stamps_ns.ndim != 1 or len(self.stamps_ns) == 0 or (np.diff(self.stamps_ns) < 0).any():
            raise ConfigError("contents.stamps", "An edge needs at least one time, and its times must ascend.")

    @property
    def rate_hz(self) -> float | None:
        """Mean number of transforms per second; None for fewer than two."""
        span = (int(self.stamps_ns[-1]) - int(self.stamps_ns[0])) * 1e-9
        return (len(self.stamps_ns) - 1) / span if span > 0.0 else None

    def age_s(self, at_ns: int) -> float | None:
        """Seconds since the newest transform not later than ``at_ns``; None before the first.

        0 for a static edge, because tf2 considers it valid at all times.
        """
        if self.is_static:
            return 0.0
        index = int(np.searchsorted(self.stamps_ns, at_ns, side="right")) - 1
        return None if index < 0 else (at_ns - int(self.stamps_ns[index])) * 1e-9

    def pose_at(self, at_ns: int) -> Pose7 | None:
        """Return ``T_parent_child`` at a time; None before the first transform.

        It is interpolated between transforms, as in tf2; after the last, and for a static edge, it is the last.
        """
        stamps, poses = self.pose_stamps_ns, self.poses
        if self.is_static:
            stamps, poses = np.array([at_ns]), np.array([self.pose])
        index = int(np.searchsorted(stamps, at_ns, side="right")) - 1
        if index < 0:
            return None
        after = min(index + 1, len(stamps) - 1)
        pause = int(stamps[after]) - int(stamps[index])
        weight = (at_ns - int(stamps[index])) / pause if pause else 0.0
        around = poses_of(poses[[index, after]])
        pose = interpolated(around[slice(0, 1)], around[slice(1, 2)], np.array([weight]))
        x, y, z = (float(position) for position in pose.positions[0])
        qx, qy, qz, qw = (float(rotation) for rotation in pose.rotations[0])
        return (x, y, z, qx, qy, qz, qw)

    def ages(self, until_ns: int) -> Series:
        """Return the age over time, seconds, of a moving transform: it grows until the next one, finally to
        ``until_ns``.

        There are two rows for each transform, just before and at its arrival.
        """
        stamps = np.append(self.stamps_ns, max(until_ns, int(self.stamps_ns[-1])))
        before = np.diff(stamps, prepend=stamps[0]).astype(np.float64) * 1e-9
        ages = np.stack([before, np.zeros(len(stamps))], axis=-1).ravel()[1:-1]
        return Series(self.topic, "age", (Column("age", "s", "age"),), np.repeat(stamps, 2)[1:-1], ages[:, np.newaxis])


@dataclass(frozen=True, slots=True)
class CameraContents:
    """Contents of the first CameraInfo on ``topic``: the optical ``frame`` of the camera, and its intrinsics.

    ``intrinsics`` are those of rectified images, ``lens`` that of the others.
    """

    topic: str
    frame: str
    intrinsics: Intrinsics
    lens: Lens


@dataclass(frozen=True, slots=True)
class Column:
    """One number of a message over time: its label, unit, and plot."""

    label: str
    unit: str
    plot: str


@dataclass(frozen=True, slots=True)
class Series:
    """The numbers of one topic: ``values`` (n, columns) at ``stamps_ns`` (n,), ascending.

    The stamps are those stated by the messages; with ``recorded`` they are recording times, if none are stated.
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
    """Contents of a recording. ``notes`` are sentences on what could not be read.

    ``lines`` are the nodes' log lines, in time order, and ``lines_left_out`` the number beyond the limit.
    """

    topics: tuple[TopicContents, ...]
    edges: tuple[FrameEdge, ...] = ()
    series: tuple[Series, ...] = ()
    notes: tuple[str, ...] = ()
    lines: tuple[LogLine, ...] = ()
    lines_left_out: int = 0
    cameras: tuple[CameraContents, ...] = ()
