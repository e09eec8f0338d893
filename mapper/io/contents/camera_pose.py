"""Pose of a camera in a recording, and the image position of map points, from its CameraInfo and the transforms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.errors import ReadError
from mapper.core.se3 import from_euler, from_quaternion
from mapper.io.contents.frame_graph import chain_of, parents_of, tree_for, trees_of
from mapper.io.contents.model import Contents, FrameEdge
from mapper.io.logs.ros.camera_topics import camera_info_topic, is_rectified


class Sight(NamedTuple):
    """Image position of a point: fractions of width and height from the upper left corner; 0 if not visible."""

    where: Literal["inside", "outside", "behind"]
    u: float
    v: float


def sight_of(
    contents: Contents, topic: str, base: str, pose: Float64Array, place: Sequence[float], at_ns: int
) -> Sight:
    """Return the position in an image on ``topic`` at ``at_ns`` of a ``place`` (3,), metres in the map.

    ``pose`` (3,) is that of the robot's frame ``base`` in the map, in the plane z = 0. Raises :class:`ReadError`, with
    a short description of what the recording lacks, and the :class:`ConfigError` of
    :meth:`mapper.sensors.camera.Lens.shares`.
    """
    info = camera_info_topic(topic)
    camera = next((camera for camera in contents.cameras if camera.topic == info), None)
    if camera is None:
        raise ReadError("camera.no_info", f"the log has no CameraInfo on {info}")
    trees = trees_of(contents.edges, topic)
    mount = _mount(trees.get(tree_for(trees, topic, camera.frame), []), base, camera.frame, at_ns)
    x, y, yaw = (float(value) for value in pose)
    T_map_camera = from_euler((x, y, 0.0), 0.0, 0.0, yaw) @ mount  # noqa: N806
    seen = (np.linalg.inv(T_map_camera) @ [*place, 1.0])[:3]
    right, down, depth = seen.tolist()
    if depth <= 0.0:
        return Sight("behind", 0.0, 0.0)
    if is_rectified(topic):
        shares: tuple[float, float] | None = camera.intrinsics.shares(right / depth, down / depth)
    else:
        shares = camera.lens.shares(seen)
    if shares is None or min(shares) < 0.0 or max(shares) > 1.0:
        return Sight("outside", 0.0, 0.0)
    return Sight("inside", *shares)


def _mount(edges: Sequence[FrameEdge], base: str, frame: str, at_ns: int) -> Float64Array:
    """Return ``T_base_frame`` (4, 4) at a time. Raises :class:`ReadError` if no transforms connect the two then."""
    parents = parents_of(edges)
    from_base, from_frame = chain_of(parents, base), chain_of(parents, frame)
    common = next((name for name in from_frame if name in from_base), None)
    if common is None:
        raise ReadError("camera.no_mount", f"no transform joins the camera’s frame {frame!r} with {base!r}")
    stated = {(edge.parent, edge.child): edge for edge in edges}

    def down_to(chain: Sequence[str]) -> Float64Array:
        """Return the pose (4, 4) of the first frame of a chain in the common one."""
        pose = np.eye(4)
        for child in chain[: chain.index(common)]:
            edge = stated[parents[child], child]
            if (placed := edge.pose_at(at_ns)) is None:
                raise ReadError("camera.no_mount", f"no transform from {child!r} to {edge.parent!r} is that old")
            x, y, z, *turn = placed
            pose = from_quaternion((x, y, z), *(np.array(turn) / np.linalg.norm(turn)).tolist()) @ pose
        return pose

    return np.linalg.inv(down_to(from_base)) @ down_to(from_frame)
