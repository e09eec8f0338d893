"""Detection of a cloud's format from its first bytes, reading of cloud files, and clouds of recordings."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.clouds.content import HEAD_BYTES, content, plain_text
from mapper.io.clouds.graph import graph_nodes, looks_like_graph
from mapper.io.clouds.kitti import looks_like_kitti, read_kitti
from mapper.io.clouds.las import read_las
from mapper.io.clouds.pcd import read_pcd
from mapper.io.clouds.pcd_header import looks_like_pcd
from mapper.io.clouds.ply import read_ply
from mapper.io.clouds.text import looks_like_text, read_text
from mapper.io.clouds.vtk import read_vtk
from mapper.io.logs.archives.unpacking import Progress, Unpacked, opened
from mapper.io.logs.containers.container import Container
from mapper.io.logs.foreign import not_a_log, trajectory_format, what_else
from mapper.io.logs.opening import parts_of
from mapper.sensors.point_cloud import PointCloud, PosedCloud
from mapper.sensors.streams import CloudStream

Reader = Callable[[bytes, Limits], PointCloud]

#: name of the format → test of a file's first bytes, and reader
FORMATS: dict[str, tuple[Callable[[bytes], bool], Reader]] = {
    "PLY": (lambda head: head.startswith((b"ply\n", b"ply\r\n", b"ply ")), read_ply),
    "VTK": (lambda head: head.startswith(b"# vtk DataFile"), read_vtk),
    "LAS": (lambda head: head.startswith(b"LASF"), read_las),
    "PCD": (looks_like_pcd, read_pcd),
}
HEADERLESS = "KITTI or nuScenes"  #: points without a header
TEXT = "text"  #: XYZ, PTS and CSV, which have no distinctive first bytes


def cloud_format(head: bytes) -> str | None:
    """Return the format name of a file that starts with ``head``, decompressed; None if it is not a cloud."""
    if looks_like_kitti(head):
        return HEADERLESS
    head = plain_text(head)
    if looks_like_graph(head):
        return "scan graph"
    known = next((name for name, (begins, _) in FORMATS.items() if begins(head)), None)
    return TEXT if known is None and looks_like_text(head) and trajectory_format(head) is None else known


def format_of(path: Path, limits: Limits = DEFAULT_LIMITS) -> str | None:
    """Return :func:`cloud_format` of a file, plain or compressed. Raises :class:`ReadError` if it cannot be read."""
    with opened(path) as file:
        pieces = Unpacked(file, lambda: "at its beginning", limits)
        return cloud_format(next(iter(pieces), b"")[:HEAD_BYTES])


def read_cloud(
    path: str | os.PathLike[str], *, limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None
) -> PointCloud:
    """Return the points of the file at ``path``, plain or compressed with gzip or Zstandard, float64, in file order.

    Supported are PCD, PLY, legacy VTK, LAS, LAZ, text (XYZ, PTS, CSV), points of KITTI and nuScenes (.bin), and
    OctoMap's scan graph, whose scans are joined in the map's frame. Non-finite points are kept, so that rows match the
    file's. Raises :class:`ReadError`, saying what is wrong and where, and :class:`LimitError`.
    """

    def known(head: bytes) -> str:
        if not head:
            raise ReadError("cloud.empty", f"The file {Path(path).name!r} is empty.")
        kind = cloud_format(head)
        if kind is None and trajectory_format(head) is not None:
            raise not_a_log(head)
        if kind is None:
            what = what_else(head)
            is_none = f"is {what}, and none" if what else "is none"
            raise ReadError("cloud.format", f"The file {Path(path).name!r} {is_none} of the known formats: {_known()}.")
        return kind

    data = content(Path(path), limits, progress, known)
    kind = known(data[:HEAD_BYTES])
    if kind == HEADERLESS:
        return read_kitti(data, limits)
    data = plain_text(data)
    if kind == "scan graph":
        return _joined(graph_nodes(data, limits), limits)
    return (read_text if kind == TEXT else FORMATS[kind][1])(data, limits)


def read_scan_graph(
    path: str | os.PathLike[str], *, limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None
) -> Iterator[PosedCloud]:
    """Yield the scans of OctoMap's scan graph at ``path``, binary or text, plain or compressed, each with its pose.

    Raises the errors of :func:`read_cloud`.
    """
    data = content(Path(path), limits, progress)
    if cloud_format(data[:HEAD_BYTES]) != "scan graph" and not data.lstrip().startswith(b"#"):
        raise ReadError("cloud.format", f"The file {Path(path).name!r} is not a scan graph of OctoMap.")
    yield from graph_nodes(data, limits)


def _joined(nodes: Iterator[PosedCloud], limits: Limits) -> PointCloud:
    parts: list[PosedCloud] = []
    n = 0
    for node in nodes:
        n += len(node.cloud)
        if n > limits.max_points:
            raise LimitError("cloud.too_many_points", f"The scans have more than {limits.max_points} points together.")
        parts.append(node)
    if n == 0:
        raise ReadError("cloud.empty", "The file holds no points.")
    points = np.concatenate([part.points_in_map() for part in parts])
    pose = parts[0].pose if len(parts) == 1 else None
    return PointCloud(points, sensor_pose=pose, notes=tuple(note for part in parts for note in part.cloud.notes))


def _known() -> str:
    return ", ".join([*FORMATS, "LAZ, scan graph (OctoMap), XYZ, PTS, CSV, points of KITTI and nuScenes (.bin)"])


def open_clouds(
    path: str | os.PathLike[str], *, limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None
) -> Mapping[str, CloudStream]:
    """Return the clouds (sensor_msgs/PointCloud2) of the recording at ``path`` by topic.

    The recording is read once for its transforms, from which each stream computes the pose of a cloud's frame on the
    robot; the clouds themselves are read when a stream is iterated. Raises :class:`ReadError` for a file that is not a
    recording or has no clouds, and the errors of :func:`mapper.io.logs.open_log`.
    """
    files, kind = parts_of(Path(path), limits)
    clouds = kind.streams(files, limits, progress).clouds if isinstance(kind, Container) else {}
    if not clouds:
        raise ReadError("clouds.none", "The file holds no point clouds (sensor_msgs/PointCloud2 in a bag or an MCAP).")
    return clouds
