"""Scans of a cloud, a scan graph, a depth folder or a recording in memory, for repeated mapping."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float32Array, Float64Array, Int64Array
from mapper.core.errors import ConfigError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.clouds import read_cloud, read_depth_folder
from mapper.io.clouds.depth_folder import is_depth_folder
from mapper.io.clouds.reading import cloud_format
from mapper.io.logs.archives.unpacking import Progress
from mapper.sensors.depth_image import DepthImage
from mapper.sensors.point_cloud import PointCloud, PosedCloud
from mapper.volume.placed_scan import PlacedScan
from mapper.volume.scans.depth_sequence import DepthSequence, GatheredDepth
from mapper.volume.scans.map_offset import offset_notes, offset_of
from mapper.volume.scans.sources import ScanSource, file_head, open_source, placed_scan

MOST_POINTS = 10_000_000  #: of a sequence; beyond it, one point is kept per small cube
FINEST_M = 0.01  #: initial side of these cubes, metres; maps with a resolution that is a multiple of it lose no voxels
MOST_IN_SCAN = 50_000  #: points of one of several scans, beyond which one point is kept per cube
#: For each axis that may point up, the rotation that turns it to z.
UPS = {
    "z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "-z": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
    "y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "-y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "x": ((0, 0, -1), (0, 1, 0), (1, 0, 0)),
    "-x": ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
}
FIELDS = ("rgb", "intensity", "class")  #: kept fields of a cloud's points


@dataclass(frozen=True, slots=True)
class ScanSequence:
    """Scans in the map's frame, in order.

    ``points`` (n, 3) float32, metres, are those of all scans; scan k has rows ``starts[k]`` … ``starts[k + 1]`` − 1.
    ``origins`` (scans, 3), metres, are the sensor positions, NaN if unknown; ``stamps_ns`` (scans,) are 0 if there are
    none. The file's coordinates are these plus ``offset`` (3,). ``fields`` has the known point fields: ``rgb`` (n, 3)
    uint8, ``intensity`` (n,) float32, ``class`` (n,) integers. ``kind`` is the format; ``notes`` are sentences on the
    input. ``depth`` has the images of a depth folder, one for each scan.
    """

    kind: str
    points: Float32Array
    starts: Int64Array
    origins: Float64Array
    stamps_ns: Int64Array
    offset: Float64Array
    fields: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    depth: DepthSequence | None = None

    def __len__(self) -> int:
        return len(self.starts) - 1

    def scan(self, index: int) -> PlacedScan:
        """Return a scan."""
        origin = self.origins[index]
        points = self.points[self.starts[index] : self.starts[index + 1]]
        return PlacedScan(
            points.astype(np.float64), origin if np.isfinite(origin).all() else None, int(self.stamps_ns[index])
        )

    def depth_image(self, index: int) -> DepthImage | None:
        """Return the depth image of a scan; None if there are points only."""
        depth = self.depth
        return None if depth is None else DepthImage(depth.depth(index), depth.camera, depth.poses[index])

    @property
    def first_up(self) -> str:
        """The axis of the file, one of :data:`UPS`, that presumably points up.

        Cameras are usually held upright, so it is the axis nearest to the images' upward direction; without images it
        is z, as in REP 103.
        """
        up = None if self.depth is None else self.depth.up
        if up is None:
            return "z"
        axis = int(np.argmax(np.abs(up)))
        return ("-" if up[axis] < 0.0 else "") + "xyz"[axis]

    def with_up(self, axis: str) -> ScanSequence:
        """Return the scans rotated so that an axis of the file, one of :data:`UPS`, points up.

        Raises :class:`ConfigError` for another one.
        """
        if axis not in UPS:
            raise ConfigError(
                "volume.up", f"The axis that points up must be one of {', '.join(UPS)}, not {axis!r:.80}."
            )
        turn = np.array(UPS[axis], dtype=np.float64)
        depth = self.depth
        if depth is not None:
            poses = depth.poses.copy()
            poses[:, :3] = turn @ depth.poses[:, :3]
            depth = replace(depth, poses=poses)
        points = np.ascontiguousarray(self.points @ turn.T.astype(np.float32))
        return replace(self, points=points, origins=self.origins @ turn.T, offset=turn @ self.offset, depth=depth)

    @property
    def has_origins(self) -> bool:
        """Whether the sensor positions are known, so that free space can be mapped."""
        return bool(np.isfinite(self.origins).all())

    @property
    def nbytes(self) -> int:
        """Bytes of the arrays."""
        depth = 0 if self.depth is None else self.depth.images.nbytes
        return self.points.nbytes + sum(field.nbytes for field in self.fields.values()) + self.origins.nbytes + depth


class _Gathered:
    """Scans being read, thinned if there are too many points."""

    def __init__(self, most: int, *, is_single: bool) -> None:
        self.most, self.is_single = most, is_single
        self.side = 0.0  #: side of the cubes in which one point is kept; 0: all points are kept
        self.scans: list[Float32Array] = []
        self.count = self.seen = 0

    def add(self, points: Float32Array) -> None:
        self.seen += len(points)
        if self.side == 0.0 and not self.is_single and len(points) > MOST_IN_SCAN:
            points = points[first_in_cubes(points, FINEST_M)]
        if self.side > 0.0:
            points = points[first_in_cubes(points, self.side)]
        self.scans.append(points)
        self.count += len(points)
        while self.count > self.most and self.side < 10.0:
            self.side = max(2.0 * self.side, FINEST_M)
            self.scans = [scan[first_in_cubes(scan, self.side)] for scan in self.scans]
            self.count = sum(map(len, self.scans))

    def notes(self) -> list[str]:
        if self.count == self.seen:
            return []
        side = max(self.side, FINEST_M)
        return [
            f"{self.count:,} of {self.seen:,} points are kept: of each scan one in each cube of {100.0 * side:g} cm."
        ]


def first_in_cubes(points: Float32Array, side: float) -> Int64Array:
    """Return the indices (m,), ascending, of the first of the points (n, 3) in each cube of ``side`` metres.

    Raises :class:`ConfigError` for points that are not finite or too far from 0 for integer cube indices.
    """
    if not len(points):
        return np.empty(0, dtype=np.int64)
    far = float(np.abs(points).max())
    if not far / side < 2.0**52:
        raise ConfigError(
            "volume.too_wide", f"A point {far:.3g} m from the origin is too far away for cubes of {side:g} m."
        )
    cubes = np.floor(points.astype(np.float64) / side).astype(np.int64)
    cubes -= cubes.min(axis=0)
    sides = cubes.max(axis=0) + 1
    if float(sides[0]) * float(sides[1]) * float(sides[2]) > 2.0**62:
        _, first = np.unique(cubes, axis=0, return_index=True)  # slower, but one integer per cube does not fit
    else:
        _, first = np.unique((cubes[:, 2] * sides[1] + cubes[:, 1]) * sides[0] + cubes[:, 0], return_index=True)
    return np.sort(first)


def gather(
    path: str | os.PathLike[str],
    *,
    topic: str | None = None,
    limits: Limits = DEFAULT_LIMITS,
    progress: Progress | None = None,
    most: int = MOST_POINTS,
) -> ScanSequence:
    """Return the scans opened by :func:`mapper.volume.scans.sources.open_source`, with at most about ``most`` points.

    Raises the same errors, and :class:`ReadError` if there is no scan with a point.
    """
    if is_depth_folder(Path(path)):
        return _of_depth_folder(Path(path), limits, progress, most)
    kind = None if Path(path).is_dir() else cloud_format(file_head(Path(path), limits))
    if kind is not None and kind != "scan graph":
        return _of_cloud(Path(path), kind, limits, progress, most)
    return _of_source(open_source(path, topic=topic, limits=limits, progress=progress), most, progress)


def _of_source(source: ScanSource, most: int, progress: Progress | None) -> ScanSequence:
    gathered = _Gathered(most, is_single=False)
    origins, stamps = [], []
    offset: Float64Array | None = None
    for k, scan in enumerate(source.scans):
        if not len(scan.points):
            continue
        offset = offset_of(scan.points) if offset is None else offset
        gathered.add((scan.points - offset).astype(np.float32))
        origins.append(np.full(3, np.nan) if scan.origin is None else scan.origin - offset)
        stamps.append(scan.stamp_ns)
        if progress is not None and source.count:
            progress(min((k + 1) / source.count, 1.0))
    if offset is None:
        raise ReadError("cloud.empty", "No scan has a point.")
    return _sequence(source.kind, gathered, np.array(origins), np.array(stamps), offset, {}, source.notes)


def _of_depth_folder(path: Path, limits: Limits, progress: Progress | None, most: int) -> ScanSequence:
    folder = read_depth_folder(path, limits=limits)
    images = GatheredDepth(folder.camera, folder.unit)

    def scans() -> Iterator[PlacedScan]:
        for frame in folder.frames:
            depth = frame.read()
            cloud = PointCloud(folder.camera.points(depth), frame.stamp_ns, frame.name, depth.shape)
            scan = placed_scan(PosedCloud(cloud, frame.pose))
            if len(scan.points):
                images.add(depth, frame.pose)
                yield scan

    source = ScanSource("depth images", scans(), len(folder), list(folder.notes))
    sequence = _of_source(source, most, progress)
    return replace(sequence, notes=(*sequence.notes, *images.notes), depth=images.sequence(sequence.offset))


def _of_cloud(path: Path, kind: str, limits: Limits, progress: Progress | None, most: int) -> ScanSequence:
    cloud = read_cloud(path, limits=limits, progress=progress)
    finite = cloud.finite
    places = cloud.points[finite]
    offset = offset_of(places)
    points = (places - offset).astype(np.float32)
    fields = {name: cloud.fields[name][finite] for name in FIELDS if name in cloud.fields}
    pose = cloud.sensor_pose
    origin = np.full(3, np.nan) if pose is None else pose[:3, 3] - offset
    notes = list(cloud.notes)
    if pose is None:
        notes.append("The file does not say where the sensor was: its points are occupied, and nothing is free.")
    side = FINEST_M
    while len(points) > most and side < 10.0:
        rows = first_in_cubes(points, side)
        if len(rows) <= most:
            notes.append(f"{len(rows):,} of {len(points):,} points are kept: one in each cube of {100.0 * side:g} cm.")
            points, fields = points[rows], {name: values[rows] for name, values in fields.items()}
        side *= 2.0
    gathered = _Gathered(len(points), is_single=True)
    gathered.add(points)
    return _sequence(kind, gathered, origin[None], np.array([cloud.stamp_ns]), offset, fields, notes)


def _sequence(
    kind: str, gathered: _Gathered, origins: Float64Array, stamps: Int64Array, offset: Float64Array,
    fields: Mapping[str, NDArray[Any]], notes: list[str],
) -> ScanSequence:  # fmt: skip
    notes = [*notes, *gathered.notes(), *offset_notes(offset)]
    starts = np.concatenate([[0], np.cumsum([len(scan) for scan in gathered.scans])]).astype(np.int64)
    return ScanSequence(
        kind, np.concatenate(gathered.scans), starts, origins.reshape(-1, 3).astype(np.float64),
        stamps.astype(np.int64), offset, fields, tuple(notes),
    )  # fmt: skip
