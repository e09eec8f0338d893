"""Where a camera of a recording was, and what it saw of the map, by its CameraInfo and the static transforms."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ReadError
from mapper.core.se3 import from_euler, from_quaternion
from mapper.io.contents.frame_graph import chain_of, parents_of, tree_for, trees_of
from mapper.io.contents.model import Contents, FrameEdge
from mapper.io.logs.ros.camera_topics import camera_info_topic

Float64Array = NDArray[np.float64]


def map_projection(contents: Contents, topic: str, base: str, pose: Float64Array) -> Float64Array:
    """Return the matrix (3, 4) of :meth:`mapper.sensors.camera.Intrinsics.projection` for the images on ``topic``.

    ``pose`` (3,) is that of the robot's frame ``base`` in the map, which moves in the plane z = 0. Distortion of the
    lens is not regarded. Raises :class:`ReadError`, which says in a few words what the recording lacks.
    """
    info = camera_info_topic(topic)
    camera = next((one for one in contents.cameras if one.topic == info), None)
    if camera is None:
        raise ReadError("camera.no_info", f"the log has no CameraInfo on {info}")
    trees = trees_of(contents.edges, topic)
    mount = _mount(trees.get(tree_for(trees, topic, camera.frame), []), base, camera.frame)
    x, y, yaw = (float(value) for value in pose)
    T_map_camera = from_euler((x, y, 0.0), 0.0, 0.0, yaw) @ mount  # noqa: N806
    return camera.intrinsics.projection(np.linalg.inv(T_map_camera).astype(np.float64))


def _mount(edges: Sequence[FrameEdge], base: str, frame: str) -> Float64Array:
    """Return ``T_base_frame`` (4, 4) by static transforms. Raises :class:`ReadError` where they do not join the two."""
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
            if not edge.is_static:
                raise ReadError("camera.moves", f"the transform from {child!r} to {edge.parent!r} is not static")
            x, y, z, *turn = edge.pose
            pose = from_quaternion((x, y, z), *(np.array(turn) / np.linalg.norm(turn)).tolist()) @ pose
        return pose

    return np.linalg.inv(down_to(from_base)) @ down_to(from_frame)
