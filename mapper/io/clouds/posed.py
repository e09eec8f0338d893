"""Clouds and depth images of a recording with sensor poses, for 3D maps."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.logs.archives.unpacking import Progress
from mapper.io.logs.containers.container import Container
from mapper.io.logs.opening import parts_of
from mapper.sensors.point_cloud import PointCloud, PosedCloud
from mapper.sensors.streams import CloudStream, Mounts

KNOTS = 128  #: poses within one sweep, between which the sensor is assumed at rest


@dataclass(frozen=True, slots=True)
class PosedClouds:
    """The clouds of one topic with poses from the recording's transforms; each iteration reads the recording.

    Clouds at times without a known pose of their frame are skipped. With ``deskew``, timed points are transformed to
    the sensor's pose at the cloud's stamp. ``given`` returns poses to be used instead of the transforms. Poses are
    looked up ``time_offset`` seconds after each stamp.
    """

    stream: CloudStream
    deskew: bool = True
    given: Mounts | None = None
    time_offset: float = 0.0

    def _where(self, frame_id: str, stamps_ns: NDArray[np.int64]) -> NDArray[np.float64] | None:
        return (self.given or self.stream.poses)(frame_id, stamps_ns + round(self.time_offset * 1e9))

    def __iter__(self) -> Iterator[PosedCloud]:
        for cloud in self.stream:
            poses = self._where(cloud.frame_id, np.array([cloud.stamp_ns]))
            if poses is None:
                raise ReadError(
                    "clouds.no_poses",
                    f"Nothing in the recording says where the frame {cloud.frame_id!r:.100} of {self.stream.topic} "
                    "was: it needs tf up to a fixed frame, or odometry.",
                )
            if np.isfinite(poses[0]).all():
                yield PosedCloud(deskewed(cloud, self._where) if self.deskew else cloud, poses[0])


def deskewed(cloud: PointCloud, poses: Mounts) -> PointCloud:
    """Return a cloud with each point relative to the frame's pose at the cloud's stamp.

    ``poses`` returns ``T_fixed_frame`` at stamps. The times of the points are rounded to :data:`KNOTS` per sweep. A
    cloud without times, or at times without known poses, is returned unchanged.
    """
    if cloud.times is None or not len(cloud):
        return cloud
    known = np.isfinite(cloud.times)
    if not known.any():
        return cloud
    first, last = float(cloud.times[known].min()), float(cloud.times[known].max())
    knots = np.unique(np.append(np.linspace(first, last, KNOTS), 0.0))
    sensor_poses = poses(cloud.frame_id, cloud.stamp_ns + np.round(knots * 1e9).astype(np.int64))
    if sensor_poses is None or not np.isfinite(sensor_poses).all():
        return cloud
    stamp = int(np.searchsorted(knots, 0.0))
    relative = np.linalg.inv(sensor_poses[stamp]) @ sensor_poses
    knot = _nearest(knots, np.where(known, cloud.times, 0.0))
    points = cloud.points.astype(np.float64)
    turned = np.einsum("nij,nj->ni", relative[knot, :3, :3], points) + relative[knot, :3, 3]
    return replace(cloud, points=turned)


def _nearest(knots: NDArray[np.float64], times: NDArray[np.float64]) -> NDArray[np.int64]:
    middles = 0.5 * (knots[1:] + knots[:-1])
    return np.asarray(np.searchsorted(middles, times), dtype=np.int64)


def open_posed_clouds(
    path: str | os.PathLike[str],
    *,
    topic: str | None = None,
    tf: str | None = None,
    trajectory: str | None = None,
    time_offset: float = 0.0,
    deskew: bool = True,
    given: Mounts | None = None,
    limits: Limits = DEFAULT_LIMITS,
    progress: Progress | None = None,
) -> PosedClouds:
    """Return the clouds of the recording at ``path`` with poses, on ``topic`` or else on the first topic.

    A topic of depth images (sensor_msgs/Image of 16UC1, mono16 or 32FC1, or a CompressedImage of them, with its
    CameraInfo next to it) counts as a topic of clouds; by default it is used if there are no others. ``tf`` names the
    topic of transforms if there are several, as does a suffix of ``topic``: ``/points#/tf_gt``. ``trajectory`` names
    the poses, such as ``tf/map`` or ``odom``, and ``time_offset`` seconds are added to stamps to look them up.
    ``given`` returns poses, ``T_map_sensor`` (n, 4, 4), at stamps, to be used instead of the transforms. Raises
    :class:`ReadError` for a file that is not a recording, has no clouds, or lacks a topic, and the errors of
    :func:`mapper.io.clouds.open_clouds`.
    """
    files, kind = parts_of(Path(path), limits)
    if not isinstance(kind, Container):
        raise ReadError("clouds.none", "The file is not a recording (bag, MCAP, db3) with point clouds.")
    if topic is not None:
        topic, _, named = topic.partition("#")
        tf = named or tf
    streams = kind.streams(files, limits, progress, tf=tf, trajectory=trajectory)
    known = {**streams.clouds, **streams.depths}
    # The encoding of images is only known from their messages; drivers use such topic names for depth images. Next to
    # an image's compressedDepth there may be a JPEG of it.
    depths = sorted(
        (name for name in streams.depths if "depth" in name.lower()), key=lambda n: n.endswith("/compressed")
    )
    usual = [*streams.clouds, *depths]
    if topic is None and not usual:
        raise ReadError("clouds.none", "The recording holds no point clouds and no depth images.")
    if topic is not None and topic not in known:
        has = ", ".join(known) or "none"
        raise ReadError("clouds.topic", f"The recording has no clouds on {topic!r:.80}; it has them on: {has:.300}.")
    return PosedClouds(known[topic or usual[0]], deskew, given, time_offset)
