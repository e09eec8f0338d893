"""The clouds and IMUs of a recording as streams of its log."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from mapper.core.limits import Limits
from mapper.io.logs.archive import Source
from mapper.io.logs.cloud_messages import point_cloud
from mapper.io.logs.cutting import CLOUD
from mapper.io.logs.message_fields import BadMessageError
from mapper.io.logs.pulling import Take, pulled
from mapper.io.logs.ros_messages import imu
from mapper.io.logs.taken import Taken
from mapper.sensors.point_cloud import PointCloud
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.streams import CloudStream, ImuSamples, ImuStream

IMU = "sensor_msgs/Imu"
IMU_ROWS = 1 << 12  #: messages in one part of an IMU's stream


@dataclass(frozen=True, slots=True)
class _Recorded:
    """A recording: its files in their order, what reads one, and what was taken of all."""

    files: Sequence[Source]
    take: Take
    taken: Taken

    @property
    def limits(self) -> Limits:
        return self.taken.limits

    def clouds(self, topic: str) -> Iterator[PointCloud]:
        for message in pulled(self.files, self.take, topic, CLOUD, self.limits):
            try:
                cloud = point_cloud(message.data, cdr=message.cdr)
            except BadMessageError:
                continue
            yield cloud.whole(message.stamp_ns)

    def imu(self, topic: str) -> Iterator[ImuSamples]:
        messages = pulled(self.files, self.take, topic, IMU, self.limits)
        while part := list(islice(messages, IMU_ROWS)):
            readings = []
            for message in part:
                try:
                    one = imu(message.data, cdr=message.cdr)
                except BadMessageError:
                    continue
                readings.append((one.frame, one.stamp_ns or message.stamp_ns, one))
            if readings:
                yield ImuSamples(
                    readings[0][0],
                    np.array([stamp for _, stamp, _ in readings], dtype=np.int64),
                    np.array([one.angular_velocity for *_, one in readings]),
                    np.array([one.linear_acceleration for *_, one in readings]),
                    np.array([one.orientation for *_, one in readings]),
                )

    def mounts(self, frame: str, stamps_ns: NDArray[np.int64]) -> NDArray[np.float64] | None:
        """Return ``T_base_frame`` (n, 4, 4) at n stamps; None where tf does not name the frame's place on a base."""
        tf, children = self.taken.tf, self.taken.children
        chain = tf.ancestors(frame)
        base = tf.base_of(chain, children)
        if base == 0 and not tf.is_base(frame, children):
            return None
        poses = tf.lookup(chain[: base + 1], stamps_ns)
        out = np.tile(np.eye(4), (len(stamps_ns), 1, 1))
        out[:, :3, :3], out[:, :3, 3] = poses.matrices, poses.positions
        return out


def with_streams(log: RobotLog, files: Sequence[Source], take: Take, taken: Taken) -> RobotLog:
    """Return the log of a recording with its clouds and IMUs, which are read from ``files`` when asked for."""
    clouds, imus = streams_of(files, take, taken)
    return replace(log, clouds=clouds, imus=imus)


def streams_of(
    files: Sequence[Source], take: Take, taken: Taken
) -> tuple[dict[str, CloudStream], dict[str, ImuStream]]:
    """Return the clouds and the IMUs of a recording by topic, which are read from ``files`` when asked for."""
    recorded = _Recorded(files, take, taken)
    counts: dict[tuple[str, str], int] = {}
    for stream in taken.streams:
        if stream.kind in (CLOUD, IMU):
            counts[stream.topic, stream.kind] = counts.get((stream.topic, stream.kind), 0) + stream.count
    clouds = {
        topic: CloudStream(topic, count, partial(recorded.clouds, topic), recorded.mounts)
        for (topic, kind), count in counts.items()
        if kind == CLOUD
    }
    imus = {
        topic: ImuStream(topic, count, partial(recorded.imu, topic), recorded.mounts)
        for (topic, kind), count in counts.items()
        if kind == IMU
    }
    return clouds, imus
