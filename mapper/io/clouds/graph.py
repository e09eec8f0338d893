"""OctoMap's scan graphs: scans with poses, binary or as text.

Source: ``ScanGraph::readBinary`` and ``readPlainASCII``, ``Pointcloud::readBinary``, ``Vector3::readBinary`` and
``Quaternion::readBinary`` of octomap 1.9. The points of a node are in the scan's frame, whose pose is the node's. The
edges are not needed and not read.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError, ReadError
from mapper.core.limits import Limits
from mapper.core.se3 import from_euler, from_quaternion
from mapper.io.clouds.content import check_count, made_cloud
from mapper.io.clouds.numbers import table
from mapper.sensors.point_cloud import PointCloud, PosedCloud

POINT = np.dtype([("size", "<i4"), ("xyz", "<f8", (3,))])
POSE = struct.Struct("<i3di4d")
NORM_TOLERANCE = 0.05  #: tolerance of a quaternion's length around 1


def looks_like_graph(data: bytes) -> bool:
    """Return whether a file that starts with ``data`` is a scan graph, with a node in text or binary form."""
    if data.lstrip()[:5] in (b"NODE ", b"NODE\t"):
        return True
    if len(data) < 12:
        return False
    nodes, points, size = struct.unpack_from("<IIi", data)
    return bool(0 < nodes < 1 << 24 and 0 < points < 1 << 30 and size == 3)


def graph_nodes(data: bytes, limits: Limits) -> Iterator[PosedCloud]:
    """Yield the nodes of a graph in order. Raises :class:`ReadError`, naming the node, and :class:`LimitError`."""
    return _text_nodes(data, limits) if data.lstrip().startswith((b"NODE", b"#")) else _binary_nodes(data, limits)


def _binary_nodes(data: bytes, limits: Limits) -> Iterator[PosedCloud]:
    if len(data) < 4:
        raise ReadError("cloud.truncated", "The file ends before a scan graph’s number of nodes.")
    (count,) = struct.unpack_from("<I", data)
    if count == 0:
        raise ReadError("cloud.empty", "The scan graph has no nodes.")
    at = 4
    for node in range(count):
        if at + 4 > len(data):
            raise _cut(node, count)
        (n,) = struct.unpack_from("<I", data, at)
        at += 4
        end = at + n * POINT.itemsize
        if end + POSE.size + 4 > len(data):
            raise _cut(node, count)
        check_count(n, limits)
        table = np.frombuffer(data, POINT, n, at)
        three, x, y, z, four, *rotation = POSE.unpack_from(data, end)
        if (table["size"] != 3).any() or (three, four) != (3, 4):
            raise ReadError(
                "cloud.damaged", f"Node {node} of the scan graph is damaged: the sizes of its vectors are missing."
            )
        at = end + POSE.size + 4
        yield _posed(table["xyz"], _from_quaternion(rotation, (x, y, z), node), node, limits)


def _text_nodes(data: bytes, limits: Limits) -> Iterator[PosedCloud]:
    node, at = 0, data.find(b"NODE")
    line = data.count(b"\n", 0, max(0, at)) + 1
    if at < 0:
        raise ReadError("cloud.empty", "The scan graph has no nodes.")
    while at < len(data):
        head_end = data.find(b"\n", at)
        head = data[at : head_end if head_end >= 0 else len(data)]
        following = data.find(b"\nNODE", at)
        end = len(data) if following < 0 else following + 1
        points = table(data[head_end + 1 : end] if head_end >= 0 else b"", None, None, 3, limits, line + 1)
        yield _posed(points, _from_text(head, node), node, limits)
        line += data.count(b"\n", at, end)
        at, node = end, node + 1


def _cut(node: int, count: int) -> ReadError:
    return ReadError("cloud.truncated", f"The file ends early: {count} nodes claimed, {node} whole ones there.")


def _posed(points: NDArray[np.float64], pose: NDArray[np.float64], node: int, limits: Limits) -> PosedCloud:
    try:
        if not np.abs(pose[:3, 3]).max() <= limits.max_coordinate:  # also rejects NaN
            raise ReadError("cloud.pose", "The cloud’s pose is not finite, or too far from the origin.")
        cloud = made_cloud(points, {}, limits) if len(points) else PointCloud(np.zeros((0, 3)))
        return PosedCloud(replace(cloud, frame_id=f"node {node}"), pose)
    except (ConfigError, ReadError) as error:
        raise ReadError(error.code, f"Node {node} of the scan graph: {error.message}") from error


def _from_quaternion(u_x_y_z: list[float], place: tuple[float, float, float], node: int) -> NDArray[np.float64]:
    norm = math.hypot(*u_x_y_z)
    if not abs(norm - 1.0) <= NORM_TOLERANCE:
        raise ReadError(
            "cloud.pose",
            f"The pose of node {node} of the scan graph is not a rotation: its quaternion’s length is {norm:.3g}.",
        )
    u, x, y, z = (value / norm for value in u_x_y_z)
    return from_quaternion(place, x, y, z, u)


def _from_text(line: bytes, node: int) -> NDArray[np.float64]:
    tokens = line.decode("latin-1").split()[1:]
    try:
        x, y, z, roll, pitch, yaw = (float(token) for token in tokens[:6])
    except ValueError:
        raise ReadError(
            "cloud.pose", f"The line NODE of node {node} must have six numbers: x y z roll pitch yaw."
        ) from None
    if not math.isfinite(roll + pitch + yaw):
        raise ReadError("cloud.pose", f"The angles of node {node} are not finite: {roll}, {pitch}, {yaw}.")
    return from_euler((x, y, z), roll, pitch, yaw)
