"""Sources of scans for a map: clouds, scan graphs, depth folders and recordings."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError, WorkCancelledError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.clouds import PosedClouds, open_posed_clouds, read_cloud, read_depth_folder, read_scan_graph
from mapper.io.clouds.content import HEAD_BYTES
from mapper.io.clouds.depth_folder import is_depth_folder
from mapper.io.clouds.given_poses import GivenPoses
from mapper.io.clouds.reading import cloud_format
from mapper.io.logs.archives.unpacking import Progress, Unpacked, opened
from mapper.sensors.point_cloud import PosedCloud
from mapper.volume.occupancy.volume import Inserted, OccupancyVolume
from mapper.volume.placed_scan import PlacedScan
from mapper.volume.scans.map_offset import MapOffset


@dataclass(slots=True)
class ScanSource:
    """The scans of one file or folder, in order; iterate ``scans`` once. ``count`` is their number, if known.

    ``given_poses`` is the number of supplied poses, one for each cloud file, used so far. ``notes`` are sentences on
    the input; reading the scans adds to them.
    """

    kind: str
    scans: Iterator[PlacedScan]
    count: int | None
    notes: list[str]
    given_poses: int = 0


def open_source(
    path: str | os.PathLike[str],
    *,
    topic: str | None = None,
    tf: str | None = None,
    trajectory: str | None = None,
    time_offset: float = 0.0,
    sensor: Float64Array | None = None,
    poses: GivenPoses | None = None,
    number: int = 0,
    offset: MapOffset | None = None,
    limits: Limits = DEFAULT_LIMITS,
    progress: Progress | None = None,
) -> ScanSource:
    """Return the scans of a cloud file, a scan graph, a folder of depth images or a recording with clouds.

    The points of a cloud file are in the map's frame; its sensor was at its viewpoint, or at ``sensor`` (3,), metres.
    Clouds and depth images of a recording are placed by its transforms; ``topic`` selects one of several topics, and
    ``tf`` the topic of transforms; ``trajectory`` and ``time_offset`` are as in
    :func:`mapper.io.clouds.posed.open_posed_clouds`, and apply to nothing else. With ``poses``, the points of a cloud
    file are in the frame of its sensor, whose pose has index ``number``, and those of a recording are placed by the
    poses at their times; scan graphs and folders of depth images have their own poses. With ``offset`` the scans are
    shifted to a map's coordinates; the first scan determines it if it is not yet set. Raises :class:`ReadError` and
    :class:`LimitError` like the readers, some of them during iteration.
    """
    source = _opened_source(Path(path), topic, tf, trajectory, time_offset, sensor, poses, number, limits, progress)
    if offset is not None:
        source.scans = offset.placed(source.scans)
    return source


def _opened_source(
    path: Path,
    topic: str | None,
    tf: str | None,
    trajectory: str | None,
    time_offset: float,
    sensor: Float64Array | None,
    poses: GivenPoses | None,
    number: int,
    limits: Limits,
    progress: Progress | None,
) -> ScanSource:
    if is_depth_folder(path):
        refuse_poses(poses, path)
        folder = read_depth_folder(path, limits=limits)
        return ScanSource("depth images", map(placed_scan, folder.clouds()), len(folder), list(folder.notes))
    kind = None if path.is_dir() else cloud_format(file_head(path, limits))
    if kind == "scan graph":
        refuse_poses(poses, path)
        graph = read_scan_graph(path, limits=limits, progress=progress)
        return ScanSource(kind, map(placed_scan, graph), None, [])
    if kind is None:
        pose_at = None if poses is None else poses.at
        clouds = open_posed_clouds(
            path,
            topic=topic,
            tf=tf,
            trajectory=trajectory,
            time_offset=time_offset,
            given=pose_at,
            limits=limits,
            progress=progress,
        )
        return _of_recording(clouds)
    cloud = read_cloud(path, limits=limits, progress=progress)
    notes = list(cloud.notes)
    if poses is not None:
        if number >= len(poses):
            raise ConfigError(
                "poses.too_few", f"{poses.name} has {len(poses)} poses, and {path.name} is cloud {number + 1}."
            )
        posed = PosedCloud(cloud, poses.matrix(number))
        return ScanSource(kind, iter([placed_scan(posed)]), 1, notes, given_poses=1)
    origin = cloud.sensor_pose[:3, 3] if sensor is None and cloud.sensor_pose is not None else sensor
    if origin is None:
        notes.append("The file does not say where the sensor was: its points are occupied, and nothing is free.")
    points = cloud.points[cloud.finite].astype(np.float64)
    return ScanSource(kind, iter([PlacedScan(points, origin, cloud.stamp_ns)]), 1, notes)


def refuse_poses(poses: GivenPoses | None, path: Path) -> None:
    """Raise :class:`ConfigError` if ``poses`` are supplied for the file at ``path``, which has its own."""
    if poses is not None:
        raise ConfigError(
            "poses.own", f"{path.name} contains the poses of its scans; other poses cannot be used with it."
        )


def file_head(path: Path, limits: Limits) -> bytes:
    """Return the first bytes of a file, decompressed."""
    head = b""
    with opened(path) as file:
        for piece in Unpacked(file, lambda: "at its beginning", limits):
            head += piece
            if len(head) >= HEAD_BYTES:
                break
    return head[:HEAD_BYTES]


def placed_scan(posed: PosedCloud) -> PlacedScan:
    """Return the finite points of a posed cloud that are not too far from the origin."""
    points = posed.points_in_map()[posed.cloud.finite]
    # A message may contain any number, while values from a cloud file are checked by its reader.
    near = (np.abs(points) <= DEFAULT_LIMITS.max_coordinate).all(axis=1)
    return PlacedScan(points if near.all() else points[near], posed.origin, posed.cloud.stamp_ns)


def _of_recording(clouds: PosedClouds) -> ScanSource:
    stream = clouds.stream
    notes = [f"The clouds are those of {stream.topic}."]
    return ScanSource("recording", _with_poses(clouds, notes), stream.count, notes)


def _with_poses(clouds: PosedClouds, notes: list[str]) -> Iterator[PlacedScan]:
    n = far = 0
    for posed in clouds:
        n += 1
        scan = placed_scan(posed)
        far += int(np.count_nonzero(posed.cloud.finite)) - len(scan.points)
        yield scan
    if far:
        limit = DEFAULT_LIMITS.max_coordinate
        notes.append(f"{far:,} points are farther than {limit:g} m from the origin and are left out.")
    if n < clouds.stream.count:
        notes.append(f"{clouds.stream.count - n} of {clouds.stream.count} clouds have no pose and are left out.")


@dataclass(slots=True)
class Insertion:
    """Result of the insertion of all scans: numbers of scans, points, and ignored points."""

    scans: int = 0
    points: int = 0
    left_out: int = 0
    last_ns: int = field(default=0, repr=False)  #: stamp of the last scan with a stamp

    def insert(self, volume: OccupancyVolume, scan: PlacedScan) -> Inserted:
        """Update the map by one scan, after decay for the time since the last one; return the counts."""
        if self.last_ns and scan.stamp_ns > self.last_ns:
            volume.decay((scan.stamp_ns - self.last_ns) * 1e-9)
        self.last_ns = scan.stamp_ns or self.last_ns
        did = volume.insert_scan(scan.points, scan.origin)
        self.scans, self.points = self.scans + 1, self.points + len(scan.points)
        self.left_out += did.left_out
        return did


def insert_all(
    volume: OccupancyVolume,
    source: ScanSource,
    into: Insertion,
    progress: Callable[[float], None] | None = None,
    is_cancelled: Callable[[], bool] = lambda: False,
) -> None:
    """Update a map by all scans of a source and count them in ``into``.

    ``progress`` is called with the fraction of the scans, 0 to 1, if their number is known. Raises
    :class:`WorkCancelledError` between two scans once ``is_cancelled``, :class:`ConfigError` for a source all of whose
    points are ignored, and the errors of :meth:`OccupancyVolume.insert_scan`.
    """
    before = into.points - into.left_out
    for k, scan in enumerate(source.scans):
        if is_cancelled():
            raise WorkCancelledError("volume.cancelled", f"The map was cancelled after {into.scans} scans.")
        into.insert(volume, scan)
        if progress is not None and source.count:
            progress(min((k + 1) / source.count, 1.0))
    if into.points - into.left_out == before:
        raise ConfigError(
            "volume.no_points",
            f"None of the points is finite and within {volume.reach:g} m of 0 along each axis, as far as a map with "
            f"voxels of {volume.config.resolution:g} m goes.",
        )
