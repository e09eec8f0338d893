"""Faults of a robot: odometry drift, and specular reflection on polished walls.

Both are always recorded along with the true values, and selected when the map is made. So a fault can be switched on
and off for a whole recording, and maps of the same readings with and without it can be compared.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.core.array_types import Float64Array
from mapper.core.parameter import check_fields, flag, with_values
from mapper.simulation.kernels.reflection import reflect
from mapper.simulation.lidar import SensorConfig, pose_of, ranges_in_cones, rays_of_cone, true_ranges
from mapper.simulation.robot import PoseTuple
from mapper.simulation.worlds import World

SPECULAR_ANGLE = math.radians(30.0)  #: a beam that hits a polished wall farther than this off its normal is lost
POLISHED_LENGTH = 2.5  #: metres: straight faces at least this long are polished
ON_WALL = 1e-6  # metres: tolerance of the distance between a beam's end and the face that ended it
_MOST_SINE = math.sin(SPECULAR_ANGLE)
_LENGTHENED = np.array([0.0, np.inf], dtype=np.float16)  # for a lidar beam that returns and for one that does not


@dataclass(frozen=True, slots=True)
class Faults:
    """The faults used for the map.

    ``drift`` uses the poses of :class:`~mapper.simulation.odometry.Odometer`, which ``slam`` corrects by SLAM.
    ``specular`` uses the walls of :func:`polished_faces`: an oblique lidar beam does not return, and a sonar receives
    only the other echoes in its cone. Raises :class:`mapper.core.errors.ConfigError` for a value that is not a boolean.
    """

    # fmt: off
    drift: bool = flag(
        "Odometry drift", "faults", False,
        "Make the map with the poses that the wheels report, which drift, instead of the true ones.",
    )
    slam: bool = flag(
        "SLAM while driving", "faults", False,
        "Correct the drifting poses with SLAM of the scans, as the robot drives; without drift there is no effect.",
    )
    specular: bool = flag(
        "Polished walls", "faults", False,
        "Long straight walls reflect a slanting beam away, so that it does not return.",
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)

    def with_values(self, values: Mapping[str, Any]) -> Faults:
        """Return a copy with some values replaced. Raise :class:`mapper.core.errors.ConfigError` for invalid names or
        values.
        """
        return with_values(self, values, "fault")

    @property
    def trajectory(self) -> str:
        """The trajectory of a :class:`~mapper.simulation.recording.Recording` used for the map."""
        if not self.drift:
            return "true"
        return "slam" if self.slam else "odometry"

    @property
    def corrects_poses(self) -> bool:
        """Whether corrected poses are used for the map."""
        return self.trajectory == "slam"


@lru_cache(maxsize=16)
def polished_faces(world: World) -> Float64Array:
    """Return the polished faces (n, 4), ``(ax, ay, bx, by)`` in metres: all long straight ones."""
    length = np.hypot(*(world.seen[:, 2:] - world.seen[:, :2]).T)
    faces: Float64Array = np.ascontiguousarray(world.seen[length >= POLISHED_LENGTH])
    faces.setflags(write=False)
    return faces


def reflected_away(world: World, ranges: ArrayLike, angles: ArrayLike, sensor_pose: ArrayLike) -> NDArray[np.bool_]:
    """Return which beams (n,) a polished wall reflects away, given their true ``ranges`` (n,), without noise.

    ``angles`` (n,) are radians in the laser frame, ``sensor_pose`` (3,) is ``T_map_laser``. A beam that returns from
    anything else, or does not return, is not reflected away. Source of the effect: Probabilistic Robotics, section 6.3
    (failures of a range finder: specular reflection, for sonars on every smooth wall, for lidars on glass and polished
    surfaces).
    """
    radians = np.asarray(angles, dtype=np.float64)
    beams = np.stack([np.cos(radians), np.sin(radians)], axis=-1)
    return _reflected(world, np.ascontiguousarray(ranges, dtype=np.float64), beams, pose_of(sensor_pose))


def _reflected(world: World, ranges: Float64Array, beams: Float64Array, sensor_pose: PoseTuple) -> NDArray[np.bool_]:
    """Return :func:`reflected_away` for beams with these cosines and sines (n, 2) of their angles."""
    x, y, yaw = sensor_pose
    sensor = (x, y, math.cos(yaw), math.sin(yaw))
    out = np.empty(len(ranges), dtype=np.bool_)
    reflect(polished_faces(world), ranges, beams, sensor, _MOST_SINE, ON_WALL, out)
    return out


def lengthened(world: World, sensor: SensorConfig, sensor_pose: ArrayLike) -> NDArray[np.float16]:
    """Return by how many metres (n_readings,) polished walls lengthen each reading.

    0 for the true reading, +inf for no return; ``sensor_pose`` (3,) is ``T_map_laser``. A lidar beam either returns or
    not. A sonar receives the nearest echo of the walls in its cone that are not polished, or are within
    :data:`SPECULAR_ANGLE` of the normal. The error of half precision, a thousandth of the distance, is less than any
    sensor's noise.
    """
    x, y, yaw = pose = pose_of(sensor_pose)
    if sensor.kind == "lidar":
        gone = _reflected(world, true_ranges(world, sensor, pose), sensor.directions, pose)
        return np.take(_LENGTHENED, gone.view(np.uint8))
    heard = ranges_in_cones(world, (x, y, yaw), sensor.bearings, sensor.beam_width, sensor.range_max)
    angles = sensor.bearings[:, np.newaxis] + rays_of_cone(sensor.beam_width)
    lost = reflected_away(world, heard.ravel(), angles.ravel(), (x, y, yaw)).reshape(heard.shape)
    true = heard.min(axis=1)
    echo = np.where(lost, np.inf, heard).min(axis=1)
    returned = np.isfinite(true)
    out = np.zeros(len(true), dtype=np.float16)
    out[returned] = echo[returned] - true[returned]
    return out


def with_lengthened(ranges: NDArray[np.float32], longer: NDArray[np.float16], range_max: float) -> NDArray[np.float32]:
    """Return the readings, any shape, reported by the sensor near polished walls: see :func:`lengthened`.

    Readings beyond ``range_max`` are +inf, no return (REP 117).
    """
    reported = ranges + longer
    reported[reported > range_max] = np.inf
    return reported
