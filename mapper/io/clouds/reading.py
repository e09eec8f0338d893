"""A cloud's format recognised from its first bytes, and its reader called; the clouds of a recording."""

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

#: name of the format → what tells a file's first bytes from other ones, and its reader
FORMATS: dict[str, tuple[Callable[[bytes], bool], Reader]] = {
    "PLY": (lambda head: head.startswith((b"ply\n", b"ply\r\n", b"ply ")), read_ply),
    "VTK": (lambda head: head.startswith(b"# vtk DataFile"), read_vtk),
    "LAS": (lambda head: head.startswith(b"LASF"), read_las),
    "PCD": (looks_like_pcd, read_pcd),
}
HEADERLESS = "KITTI or nuScenes"  #: points without a header
TEXT = "text"  #: XYZ, PTS and CSV, which no first bytes tell


def cloud_format(head: bytes) -> str | None:
    """Return the name of the format of a file that begins with ``head``, unpacked; None where it is no cloud's."""
    if looks_like_kitti(head):
        return HEADERLESS
    head = plain_text(head)
    if looks_like_graph(head):
        return "scan graph"
    known = next((name for name, (begins, _) in FORMATS.items() if begins(head)), None)
    return TEXT if known is None and looks_like_text(head) and trajectory_format(head) is None else known


def format_of(path: Path, limits: Limits = DEFAULT_LIMITS) -> str | None:
    """Return :func:`cloud_format` of a file, plain or packed. Raises :class:`ReadError` where it cannot be read."""
    with opened(path) as file:
        pieces = Unpacked(file, lambda: "at its beginning", limits)
        return cloud_format(next(iter(pieces), b"")[:HEAD_BYTES])


def read_cloud(
    path: str | os.PathLike[str], *, limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None
) -> PointCloud:
    """Return the points of the file at ``path``, plain or packed with gzip or Zstandard, float64, in the file's order.

    PCD, PLY, legacy VTK, LAS, LAZ, text (XYZ, PTS, CSV), points of KITTI and nuScenes (.bin), or OctoMap's scan graph,
    whose scans are joined in the map's frame. Points that are not finite stay where they are, so that rows agree with
    the file's. Raises :class:`ReadError`, saying what is wrong and where, and :class:`LimitError`.
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
    """Yield the scans of OctoMap's scan graph at ``path``, binary or text, plain or packed, each with its pose.

    Raises as :func:`read_cloud`.
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

    The recording is read once for its transforms, by which each stream says where a cloud's frame was on the robot; the
    clouds themselves are read when a stream is iterated. Raises :class:`ReadError` for a file that is no recording or
    has no clouds, and as :func:`mapper.io.logs.open_log`.
    """
    files, kind = parts_of(Path(path), limits)
    clouds = kind.streams(files, limits, progress).clouds if isinstance(kind, Container) else {}
    if not clouds:
        raise ReadError("clouds.none", "The file holds no point clouds (sensor_msgs/PointCloud2 in a bag or an MCAP).")
    return clouds
