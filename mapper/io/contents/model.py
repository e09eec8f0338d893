"""The contents of a recording: its topics, its transforms over time, and the series of numbers for plots."""

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

#: The types of messages of which a picture can be made (:mod:`mapper.io.contents.pictures`).
CAMERAS = frozenset({"sensor_msgs/Image", "sensor_msgs/CompressedImage"})
PICTURED = CAMERAS | {"sensor_msgs/PointCloud2"}


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
    ``pose`` is the last that was recorded, ``T_parent_child``: x, y, z, metres, and the quaternion x, y, z, w. Of one
    that moves, ``poses`` (m, 7) are those at ``pose_stamps_ns`` (m,), ascending; in a long recording not all of them.
    ``publishers`` are the nodes that published it, where the recording names them.
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

    def pose_at(self, at_ns: int) -> Pose7 | None:
        """Return ``T_parent_child`` at a moment; None before the first transform.

        Between two transforms it is interpolated, as tf2 does; after the last, and of a static edge, it is the last.
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
        """Return the age over time, seconds, of a transform that moves: it grows up to each, the last to ``until_ns``.

        Two rows for each transform, just before it came and as it came.
        """
        stamps = np.append(self.stamps_ns, max(until_ns, int(self.stamps_ns[-1])))
        before = np.diff(stamps, prepend=stamps[0]).astype(np.float64) * 1e-9
        ages = np.stack([before, np.zeros(len(stamps))], axis=-1).ravel()[1:-1]
        return Series(self.topic, "age", (Column("age", "s", "age"),), np.repeat(stamps, 2)[1:-1], ages[:, np.newaxis])


@dataclass(frozen=True, slots=True)
class CameraContents:
    """What the CameraInfo on ``topic`` states first: the optical ``frame`` of the camera, and what it images.

    ``intrinsics`` are those of rectified images, ``lens`` is that of the others.
    """

    topic: str
    frame: str
    intrinsics: Intrinsics
    lens: Lens


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
