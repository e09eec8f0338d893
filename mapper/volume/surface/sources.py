"""Surfaces from files: depth folders image by image, other files with clouds point by point."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError, WorkCancelledError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.clouds import read_depth_folder
from mapper.io.clouds.depth_folder import is_depth_folder
from mapper.io.clouds.given_poses import GivenPoses
from mapper.volume.scans.map_offset import MapOffset
from mapper.volume.scans.sources import open_source
from mapper.volume.surface.tsdf import Fused, TsdfVolume


@dataclass(slots=True)
class Fusions:
    """Result of a fusion: the number of ``scans`` (depth images or clouds) and of pixels or points ``used``.

    ``given_poses`` is the number of supplied poses, one for each cloud file, that were used. ``notes`` are sentences on
    the input.
    """

    scans: int = 0
    used: int = 0
    given_poses: int = 0
    notes: list[str] = field(default_factory=list)

    def count(self, fused: Fused) -> None:
        """Add the counts of one scan."""
        self.scans += 1
        self.used += fused.used


def fuse_all(
    volume: TsdfVolume,
    path: str | os.PathLike[str],
    into: Fusions,
    *,
    topic: str | None = None,
    tf: str | None = None,
    trajectory: str | None = None,
    time_offset: float = 0.0,
    sensor: Float64Array | None = None,
    poses: GivenPoses | None = None,
    offset: MapOffset | None = None,
    limits: Limits = DEFAULT_LIMITS,
    progress: Callable[[float], None] | None = None,
    is_cancelled: Callable[[], bool] = lambda: False,
) -> None:
    """Update a map with all scans of a depth folder, a cloud, a scan graph or a recording with clouds.

    ``topic`` to ``offset`` are as in :func:`mapper.volume.scans.sources.open_source`; ``progress`` is called with the
    fraction of the scans, 0 to 1, if their number is known. Raises the errors of the readers,
    :class:`WorkCancelledError` between two scans once ``is_cancelled``, and :class:`ConfigError` if a sensor position
    is unknown or nothing was used.
    """
    before, scans = into.used, into.scans

    def step(count: int | None) -> None:
        if progress is not None and count:
            progress(min((into.scans - scans) / count, 1.0))
        if is_cancelled():
            raise WorkCancelledError("tsdf.cancelled", f"The surface was cancelled after {into.scans} scans.")

    if is_depth_folder(Path(path)) and poses is None:
        folder = read_depth_folder(path, limits=limits)
        into.notes += folder.notes
        for frame in folder.frames:
            into.count(volume.fuse_depth(frame.read(), folder.camera, frame.pose))
            step(len(folder))
    else:
        source = open_source(
            path,
            topic=topic,
            tf=tf,
            trajectory=trajectory,
            time_offset=time_offset,
            sensor=sensor,
            poses=poses,
            number=into.given_poses,
            offset=offset,
            limits=limits,
        )
        into.given_poses += source.given_poses
        for scan in source.scans:
            if scan.origin is None:
                raise ConfigError(
                    "tsdf.no_origin", "The file does not say where the sensor was, from which distances are measured."
                )
            into.count(volume.fuse_points(scan.points, scan.origin))
            step(source.count)
        into.notes += source.notes
    if into.used == before:
        raise ConfigError(
            "tsdf.nothing", "The image or cloud has no point that is finite, in range and within the map’s lattice."
        )
