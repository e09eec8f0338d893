"""The point clouds of a recording, without cutting scans out of them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from mapper.core.errors import ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.logs.archives.unpacking import Progress
from mapper.io.logs.containers.container import Container
from mapper.io.logs.opening import parts_of
from mapper.sensors.streams import CloudStream


def open_clouds(
    path: str | os.PathLike[str], *, limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None
) -> Mapping[str, CloudStream]:
    """Return the clouds (sensor_msgs/PointCloud2) of the recording at ``path`` by topic.

    The recording is read once for its transforms, by which each stream says where a cloud's frame was on the robot; the
    clouds themselves are read when a stream is iterated. Raises :class:`ReadError` for a file that is no recording or
    has no clouds, and as :func:`mapper.io.logs.open_log`.
    """
    files, kind = parts_of(Path(path), limits)
    clouds = kind.streams(files, limits, progress).clouds if isinstance(kind, Container) else {}
    if not clouds:
        raise ReadError("clouds.none", "The file holds no point clouds (sensor_msgs/PointCloud2 in a bag or an MCAP).")
    return clouds
