"""Places of the camera from which one looks at a world or a map."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import product
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from server.sessions.scene_controls import Bounds, Sight
from server.stream.message_parts import CameraName, RobotCameraName

Vector = tuple[float, float, float]

#: Name → direction from the centre of the bounds to the camera, in sizes of the bounds, which is its least distance.
#: From straight above, the camera is a little to the south, so that north is up.
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


#: Cameras that move with the robot: name → where it is and where it looks, seen from the robot, x ahead and z up,
#: metres. What the camera of the robot itself looks at is near, so that dragging turns it and hardly moves it.
ROBOT_CAMERAS: Mapping[RobotCameraName, tuple[Vector, Vector]] = MappingProxyType(
    {"follow": ((-4.0, 0.0, 2.5), (1.0, 0.0, 0.0)), "first person": ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0))}
)


class Aim(NamedTuple):
    """Where a camera was told to look from, for a picture of an aspect ratio."""

    name: CameraName
    aspect: float
    position: Vector  #: metres


DEFAULT_BOUNDS: Bounds = (-10.0, -10.0, 10.0, 10.0)  #: metres, where a model states none
FOV = 0.8  #: vertical field of view of all cameras, radians
MARGIN = 1.03  #: by which a box is seen smaller than the picture
ASPECT = 1.3  #: aspect ratio from which the distances of :data:`CAMERAS` are meant


def camera_at(
    name: CameraName, bounds: Bounds, aspect: float, heights: tuple[float, float] | None = None
) -> tuple[Vector, Vector]:
    """Return where the camera ``name`` is and what it looks at, metres; in a narrow picture it is farther away.

    It looks at the floor, or at the middle of ``heights``, from where the whole box of the bounds and the heights is in
    the picture.
    """
    x0, y0, x1, y1 = bounds
    x, y, size = (x0 + x1) / 2, (y0 + y1) / 2, max(x1 - x0, y1 - y0, 2.0)
    z0, z1 = heights or (0.0, 0.0)
    if heights is not None:
        size = max(x1 - x0, y1 - y0, 1.3 * (z1 - z0), 0.1)
    centre, direction = np.array([x, y, (z0 + z1) / 2]), np.array(CAMERAS[name])
    far = size * farther(aspect) * float(np.linalg.norm(direction))
    far = max(far, _least_distance(direction, np.array([x1 - x0, y1 - y0, z1 - z0]), aspect))
    place = centre + far * direction / np.linalg.norm(direction)
    return _vector(place), _vector(centre)


def robot_camera_at(name: RobotCameraName, sight: Sight) -> tuple[Vector, Vector]:
    """Return where the camera ``name`` is and what it looks at, metres; that of the robot looks up and down with it."""
    place, look_at = ROBOT_CAMERAS[name]
    if name == "first person":
        return sight.place, _vector(np.array(sight.place) + look_at[0] * np.array(sight.ahead))
    return carried(place, sight), carried(look_at, sight)


def carried(place: ArrayLike, sight: Sight) -> Vector:
    """Return where a place is on the map, metres, that is known from the robot, x ahead and z up."""
    return _vector(_turn(sight) @ np.asarray(place) + sight.place)


def seen_from(place: ArrayLike, sight: Sight) -> Vector:
    """Return where a place of the map is, metres, seen from the robot, x ahead and z up."""
    return _vector((np.asarray(place) - sight.place) @ _turn(sight))


def _turn(sight: Sight) -> NDArray[np.float64]:
    """Return the rotation (3, 3) about z from the robot's axes to those of the map."""
    yaw = math.atan2(sight.ahead[1], sight.ahead[0])
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def _least_distance(direction: NDArray[np.float64], sides: NDArray[np.float64], aspect: float) -> float:
    """Return how far away along ``direction`` (3,) a camera sees a box of ``sides`` (3,) about its aim, metres.

    A corner c that is c · d nearer to the camera than its aim is in the picture if |c · up| ≤ (far − c · d) tan(FOV/2),
    and to the sides likewise, times the aspect ratio.
    """
    d = direction / np.linalg.norm(direction)
    right = np.cross([0.0, 0.0, 1.0], d)
    right /= np.linalg.norm(right)
    corners = 0.5 * sides * np.array(list(product((-1.0, 1.0), repeat=3)))
    slope = math.tan(FOV / 2) / MARGIN
    off = np.maximum(np.abs(corners @ np.cross(d, right)), np.abs(corners @ right) / aspect)
    return float(np.max(corners @ d + off / slope))


def _vector(place: NDArray[np.float64]) -> Vector:
    return float(place[0]), float(place[1]), float(place[2])


def farther(aspect: float) -> float:
    """Return how many times farther away the camera is in a picture of this aspect ratio."""
    return min(max(ASPECT / aspect, 1.0), 4.0)
