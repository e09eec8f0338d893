"""Point clouds and IMU samples of a recording, read on request."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.sensors.point_cloud import PointCloud

#: Returns ``T_base_frame`` or ``T_fixed_frame``, (n, 4, 4), of a frame at n stamps, ns; None if unknown.
Mounts = Callable[[str, Int64Array], Float64Array | None]


@dataclass(frozen=True, slots=True)
class CloudStream:
    """The point clouds of one topic; ``count`` is the number of messages.

    Nothing is cached: each iteration reads the recording from the start and holds a few clouds in memory at a time.
    Messages that are not clouds are skipped. ``mounts`` returns the pose of a cloud's frame on the robot, and ``poses``
    in the recording's fixed frame, NaN at unknown times. Iterating raises :class:`ReadError` and :class:`LimitError`
    like opening the recording.
    """

    topic: str
    count: int
    read: Callable[[], Iterator[PointCloud]]
    mounts: Mounts
    poses: Mounts

    def __iter__(self) -> Iterator[PointCloud]:
        return self.read()

    def stamps_ns(self) -> Int64Array:
        """Return the stamps (n,) of all clouds in recording order; this reads the recording."""
        return np.array([cloud.stamp_ns for cloud in self], dtype=np.int64)


@dataclass(frozen=True, slots=True)
class ImuSamples:
    """Some messages of an IMU in the frame ``frame_id``: ``stamps_ns`` (n,) int64.

    ``angular_velocity`` (n, 3) rad/s, ``linear_acceleration`` (n, 3) m/s², and ``orientation`` (n, 4) the unit
    quaternion x y z w, NaN if not stated. Source: sensor_msgs/Imu.
    """

    frame_id: str
    stamps_ns: Int64Array
    angular_velocity: Float64Array
    linear_acceleration: Float64Array
    orientation: Float64Array

    def __len__(self) -> int:
        return len(self.stamps_ns)


@dataclass(frozen=True, slots=True)
class ImuStream:
    """The messages of one IMU, not cached, like a :class:`CloudStream`. Iterating yields them in parts."""

    topic: str
    count: int
    read: Callable[[], Iterator[ImuSamples]]
    mounts: Mounts

    def __iter__(self) -> Iterator[ImuSamples]:
        return self.read()

    def samples(self) -> ImuSamples:
        """Return all messages, 88 bytes each."""
        parts = list(self)
        if not parts:
            return ImuSamples("", np.zeros(0, dtype=np.int64), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 4)))
        return ImuSamples(
            parts[0].frame_id,
            np.concatenate([part.stamps_ns for part in parts]),
            np.concatenate([part.angular_velocity for part in parts]),
            np.concatenate([part.linear_acceleration for part in parts]),
            np.concatenate([part.orientation for part in parts]),
        )
