"""Simulated 3D sensors, lidars and a depth camera, and the world they measure."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.core.parameter import check_fields, choice, number, table_of, with_values
from mapper.core.se3 import from_euler
from mapper.sensors.camera import Intrinsics
from mapper.sensors.depth_image import DepthImage
from mapper.simulation.kernels.space import Space, cast_in_space
from mapper.simulation.lidar import RANGE_MIN, TURN
from mapper.simulation.plan_map import is_furniture
from mapper.simulation.shapes import Polygon
from mapper.simulation.worlds import World


@dataclass(frozen=True, slots=True)
class Sensor3D:
    """Values of all rows of :data:`SENSOR_3D_PARAMETERS`; each field states its unit and meaning.

    Raises :class:`ConfigError` naming the invalid field.
    """

    # fmt: off
    sensor: str = choice(
        "3D sensor", "sensor_3d", "spinning_lidar",
        "A spinning lidar has rings of beams; a tilted one has one plane, swept by the robot; a depth camera measures "
        "every pixel of an image.", ("spinning_lidar", "tilted_lidar", "depth_camera"),
    )
    mount_height: float = number(
        "Height of its mount", "sensor_3d", 0.6, "Height of the sensor above the ground.", "m", 0.1, 1.8, 0.05,
    )
    tilt: float = number(
        "Tilt", "sensor_3d", 0.25, "How far its axis points below the horizon.",
        "rad", -0.8, 0.8, 0.05, only_for=("tilted_lidar", "depth_camera"),
    )
    rings: int = number(
        "Rings", "sensor_3d", 16, "Rings of beams, spread evenly over the vertical field of view.",
        "", 4, 32, 1, only_for=("spinning_lidar",),
    )
    vertical_view: float = number(
        "Vertical field of view", "sensor_3d", math.radians(30.0),
        "The angle between the lowest and the highest ring, half of it below the horizon.",
        "rad", 0.1, 1.6, 0.02, only_for=("spinning_lidar",),
    )
    beams: int = number(
        "Beams", "sensor_3d", 360, "Beams of a ring, or of the plane, in a turn.",
        "", 60, 720, 30, only_for=("spinning_lidar", "tilted_lidar"),
    )
    columns: int = number(
        "Columns", "sensor_3d", 96, "Columns of the depth image; it has three quarters as many rows.",
        "", 16, 160, 16, only_for=("depth_camera",),
    )
    view: float = number(
        "Field of view", "sensor_3d", 1.2, "Angle between the left and the right border of an image.",
        "rad", 0.4, 2.0, 0.05, only_for=("depth_camera",),
    )
    reach: float = number(
        "3D range", "sensor_3d", 8.0,
        "The farthest the sensor can measure; a beam that meets nothing nearer returns nothing.", "m", 1.0, 20.0, 0.5,
    )
    noise: float = number(
        "3D noise σ", "sensor_3d", 0.01, "Standard deviation of a reading about the true distance.",
        "m", 0.0, 0.3, 0.005,
    )
    rate: float = number("3D scan rate", "sensor_3d", 4.0, "Scans or images in a second.", "Hz", 0.5, 10.0, 0.5)
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)
        for name in ("rings", "beams", "columns"):
            value = getattr(self, name)
            if value != int(value):
                raise ConfigError(f"parameter.{name}", f"The number of {name} must be whole, not {value!r}.")
            object.__setattr__(self, name, int(value))

    def with_values(self, values: Mapping[str, Any]) -> Sensor3D:
        """Return a copy with some values replaced. Raise :class:`ConfigError` for an unknown name or an invalid
        value.
        """
        return with_values(self, values, "parameter of the 3D sensor")

    @property
    def directions(self) -> Float64Array:
        """Unit directions (n, 3) of the beams in the sensor's frame, x forward, y left, z up."""
        return _DIRECTIONS[self.sensor](self)

    @property
    def mount(self) -> Float64Array:
        """``T_base_sensor`` (4, 4): above the robot's centre, with the axis of a tilted sensor below the horizon."""
        pitch = 0.0 if self.sensor == "spinning_lidar" else self.tilt
        return from_euler((0.0, 0.0, self.mount_height), 0.0, pitch, 0.0)


SENSOR_3D_PARAMETERS = table_of(Sensor3D)
#: Rotation from the optical frame (x right, y down, z forward) to a sensor's frame (x forward, y left, z up), REP 103.
SENSOR_OF_OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


def _ring(sensor: Sensor3D, elevations: Float64Array) -> Float64Array:
    azimuth = -0.5 * TURN + TURN / sensor.beams * np.arange(sensor.beams)
    level = np.column_stack([np.cos(azimuth), np.sin(azimuth)])
    rings = [
        np.column_stack([math.cos(angle) * level, np.full(sensor.beams, math.sin(angle))])
        for angle in elevations.tolist()
    ]
    return np.ascontiguousarray(np.concatenate(rings))


def _spinning(sensor: Sensor3D) -> Float64Array:
    return _ring(sensor, np.linspace(-0.5 * sensor.vertical_view, 0.5 * sensor.vertical_view, sensor.rings))


def _tilted(sensor: Sensor3D) -> Float64Array:
    return _ring(sensor, np.zeros(1))


def _camera(sensor: Sensor3D) -> Intrinsics:
    """Return the pinhole model of a depth camera with square pixels and a centred optical axis."""
    columns, rows = sensor.columns, sensor.columns * 3 // 4
    focal = 0.5 * columns / math.tan(0.5 * sensor.view)
    return Intrinsics(columns, rows, focal, focal, 0.5 * (columns - 1), 0.5 * (rows - 1))


def _pixels(sensor: Sensor3D) -> Float64Array:
    """Return the rays of the depth camera's pixels in row-major order."""
    camera = _camera(sensor)
    left = -(np.arange(camera.width) - camera.cx) / camera.fx
    up = -(np.arange(camera.height) - camera.cy) / camera.fy
    y, z = (axis.ravel() for axis in np.meshgrid(left, up))
    rays = np.column_stack([np.ones(len(y)), y, z])
    return np.ascontiguousarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))


_DIRECTIONS: Mapping[str, Callable[[Sensor3D], Float64Array]] = MappingProxyType(
    {"spinning_lidar": _spinning, "tilted_lidar": _tilted, "depth_camera": _pixels}
)


@dataclass(frozen=True, slots=True, eq=False)
class Scan3D:
    """Readings of a 3D sensor: ``ranges`` (n,) metres along its beams, +inf for no return, and the time.

    ``pose`` (x, y, yaw) is the base's believed ``T_map_base``.
    """

    sensor: Sensor3D
    ranges: NDArray[np.float32]
    pose: tuple[float, float, float]
    stamp_s: float

    def ends(self) -> tuple[Float64Array, Float64Array]:
        """Return the ends (n, 3) of the beams in the map frame and the sensor position (3,), metres.

        A beam without a return ends at 1.1 times the sensor's range.
        """
        pose = sensor_pose(self.sensor, self.pose)
        reached = np.where(np.isfinite(self.ranges), self.ranges, 1.1 * self.sensor.reach)
        return self.sensor.directions * reached[:, None] @ pose[:3, :3].T + pose[:3, 3], pose[:3, 3]

    def depth_image(self) -> DepthImage | None:
        """Return the image of a depth camera, 0 for no return; None for another sensor."""
        if self.sensor.sensor != "depth_camera":
            return None
        camera, pose = _camera(self.sensor), sensor_pose(self.sensor, self.pose)
        pose[:3, :3] = pose[:3, :3] @ SENSOR_OF_OPTICAL
        along = self.ranges * self.sensor.directions[:, 0]
        depth = np.where(np.isfinite(along), along, 0.0).astype(np.float32)
        return DepthImage(depth.reshape(camera.height, camera.width), camera, pose)


def sensor_pose(sensor: Sensor3D, base_pose: ArrayLike) -> Float64Array:
    """Return ``T_map_sensor`` (4, 4) for a robot at ``base_pose`` (x, y, yaw) on the ground."""
    x, y, yaw = (float(v) for v in np.asarray(base_pose, dtype=np.float64))
    return np.asarray(from_euler((x, y, 0.0), 0.0, 0.0, yaw) @ sensor.mount)


def measure_3d(world: World, sensor: Sensor3D, base_pose: ArrayLike, rng: np.random.Generator) -> NDArray[np.float32]:
    """Return the ranges (n,) reported by the sensor of a robot at ``base_pose`` (3,), ``T_map_base``, at one instant.

    The noise is that of :func:`mapper.simulation.lidar.measure`: Gaussian with σ = ``noise`` along the beam, no reading
    below :data:`RANGE_MIN`, +inf beyond ``reach``. For a depth camera these are distances along the rays of the pixels.
    """
    pose = sensor_pose(sensor, base_pose)
    directions = sensor.directions
    true = cast(world, pose[:3, 3], directions @ pose[:3, :3].T, sensor.reach)
    noisy = np.maximum(true + sensor.noise * rng.standard_normal(len(true)), RANGE_MIN).astype(np.float32)
    noisy[noisy > sensor.reach] = np.inf
    return noisy


WALL_HEIGHT = 2.2  #: metres: of the walls of all worlds
FURNITURE_HEIGHT = 0.75  #: metres: of solids that are not walls


def prisms(world: World) -> Iterator[tuple[Polygon, float, tuple[float, float, float]]]:
    """Yield outline, bottom and top of all solids: first those that stand on the ground, then the blocks."""
    for solid in world.solids:
        yield solid, 0.0, (FURNITURE_HEIGHT if is_furniture(solid) else WALL_HEIGHT, 0.0, 0.0)
    for block in world.blocks:
        yield block.outline, block.bottom, block.top


@lru_cache(maxsize=16)
def space_of(world: World) -> Space:
    """Return the solids of a world in the form that the kernels use, computed once per world."""
    edges, boxes, tops, first = [], [], [], [0]
    for outline, bottom, (a, b, c) in prisms(world):
        edges.append(np.hstack([outline, np.roll(outline, -1, axis=0)]))
        first.append(first[-1] + len(outline))
        highest = float((a + outline @ (b, c)).max())
        boxes.append([*outline.min(axis=0), bottom, *outline.max(axis=0), highest])
        tops.append([a, b, c])
    return Space(
        np.ascontiguousarray(np.vstack([np.empty((0, 4)), *edges])),
        np.array(first, dtype=np.int64),
        np.array(boxes, dtype=np.float64).reshape(-1, 6),
        np.array(tops, dtype=np.float64).reshape(-1, 3),
    )


def cast(world: World, origin: ArrayLike, directions: ArrayLike, range_max: float) -> Float64Array:
    """Return the distance (n,), metres, from ``origin`` (3,) along unit ``directions`` (n, 3) to a surface.

    Map frame; +inf if a ray hits nothing within ``range_max`` metres. Raises :class:`ConfigError` for other shapes and
    lengths.
    """
    start = np.ascontiguousarray(origin, dtype=np.float64)
    away = np.ascontiguousarray(directions, dtype=np.float64)
    if start.shape != (3,) or away.ndim != 2 or away.shape[1] != 3 or not np.isfinite(start).all():
        raise ConfigError("simulation.rays", f"Rays need an origin (3,) and directions (n, 3), not {away.shape}.")
    if not np.allclose(np.linalg.norm(away, axis=1), 1.0, atol=1e-6):
        raise ConfigError("simulation.rays", "The directions of rays must have the length 1.")
    out = np.empty(len(away))
    cast_in_space(space_of(world), start, away, range_max, out)
    return out
