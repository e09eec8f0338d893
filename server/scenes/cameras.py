"""Camera positions for viewing a world or a map."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import product
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from server.sessions.scene_controls import Bounds, Heights, Sight
from server.stream.message_parts import CameraName, RobotCameraName

Vector = tuple[float, float, float]

#: Name → direction from the centre of the bounds to the camera, of any length. The camera above is moved slightly to
#: the south, so that north is up.
CAMERAS: Mapping[CameraName, Vector] = MappingProxyType(
    {
        "overview": (0.0, -0.75, 0.95),
        "above": (0.0, -0.001, 1.35),
        "south": (0.0, -1.25, 0.35),
        "west": (-1.25, 0.0, 0.35),
        "north": (0.0, 1.25, 0.35),
        "east": (1.25, 0.0, 0.35),
    }
)


#: Cameras that move with the robot: name → position and target relative to the robot, x ahead and z up, metres. The
#: target of the robot's own camera is near, so that dragging turns the camera and hardly moves it.
ROBOT_CAMERAS: Mapping[RobotCameraName, tuple[Vector, Vector]] = MappingProxyType(
    {"follow": ((-4.0, 0.0, 2.5), (1.0, 0.0, 0.0)), "first person": ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0))}
)


class Aim(NamedTuple):
    """Pose assigned to a camera, for a picture of an aspect ratio."""

    name: CameraName
    aspect: float
    position: Vector  #: metres


DEFAULT_BOUNDS: Bounds = (-10.0, -10.0, 10.0, 10.0)  #: metres, if a model has none
FOV = 0.8  #: vertical field of view of all cameras, radians
MARGIN = 1.03  #: factor by which a box appears smaller than the picture
LEAST_SIDE = 0.1  #: of a box from above, metres


def camera_at(name: CameraName, bounds: Bounds, aspect: float, heights: Heights) -> tuple[Vector, Vector]:
    """Return the position and the target of the camera ``name``, metres.

    The box of the bounds and the heights fills a picture of the aspect ratio ``aspect``, in width or in height. Let u,
    r, d be a corner's coordinates upwards and to the right in the picture and towards the camera, and t the tangent of
    half of the field of view. A camera at the distance f that is moved by c upwards sees the corner if |u - c| ≤ (f -
    d) t. So c is between max(u + d t) - f t and min(u - d t) + f t, which leaves one c at the least f. The same holds
    for the direction to the right.
    """
    low, high = (np.array([*bounds[at : at + 2], heights[at // 2]]) for at in (0, 2))
    sides = np.maximum(high - low, (LEAST_SIDE, LEAST_SIDE, 0.0))
    d = np.array(CAMERAS[name]) / np.linalg.norm(CAMERAS[name])
    right = np.cross([0.0, 0.0, 1.0], d)
    right /= np.linalg.norm(right)
    corners = 0.5 * sides * np.array(list(product((-1.0, 1.0), repeat=3)))
    slope = math.tan(FOV / 2) / MARGIN
    look_at, far = 0.5 * (low + high), 0.0
    for axis, t in ((np.cross(d, right), slope), (right, slope * aspect)):
        most, least = np.max(corners @ axis + corners @ d * t), np.min(corners @ axis - corners @ d * t)
        look_at += 0.5 * (most + least) * axis
        far = max(far, float(most - least) / (2.0 * t))
    return _vector(look_at + far * d), _vector(look_at)


def robot_camera_at(name: RobotCameraName, sight: Sight) -> tuple[Vector, Vector]:
    """Return the position and the target of the camera ``name``, metres. The robot's own camera pitches with it."""
    place, look_at = ROBOT_CAMERAS[name]
    if name == "first person":
        return sight.place, _vector(np.array(sight.place) + look_at[0] * np.array(sight.ahead))
    return carried(place, sight), carried(look_at, sight)


def carried(place: ArrayLike, sight: Sight) -> Vector:
    """Return the map coordinates, metres, of a place given relative to the robot, x ahead and z up."""
    return _vector(_turn(sight) @ np.asarray(place) + sight.place)


def seen_from(place: ArrayLike, sight: Sight) -> Vector:
    """Return the coordinates of a place of the map, metres, relative to the robot, x ahead and z up."""
    return _vector((np.asarray(place) - sight.place) @ _turn(sight))


def _turn(sight: Sight) -> NDArray[np.float64]:
    """Return the rotation (3, 3) about z from the robot's axes to those of the map."""
    yaw = math.atan2(sight.ahead[1], sight.ahead[0])
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def _vector(place: NDArray[np.float64]) -> Vector:
    return float(place[0]), float(place[1]), float(place[2])
