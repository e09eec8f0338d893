"""Faults of a robot: odometry drift, and specular reflection on polished walls.

Both are recorded all the time, together with the true values, and selected when the map is made: so a fault can be
switched on and off for a whole recording, and maps of the same readings with and without it can be compared.
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

SPECULAR_ANGLE = math.radians(30.0)  #: a beam that meets a polished wall farther than this off its normal is lost
POLISHED_LENGTH = 2.5  #: metres: straight faces at least this long are polished
ON_WALL = 1e-6  # metres by which the end of a beam may miss the face that ended it
_MOST_SINE = math.sin(SPECULAR_ANGLE)
_LENGTHENED = np.array([0.0, np.inf], dtype=np.float16)  # of a lidar's beam that returns and of one that does not


@dataclass(frozen=True, slots=True)
class Faults:
    """The faults that the map is made with.

    ``drift`` uses the poses of :class:`~mapper.simulation.odometry.Odometer`, with ``slam`` as SLAM corrects them.
    ``specular`` uses the walls of :func:`polished_faces`: a lidar's slanting beam does not return, a sonar hears only
    what else is in its cone.
    Raises :class:`mapper.core.errors.ConfigError` for a value that is not true or false.
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
        """Return a copy with some values replaced; raise :class:`mapper.core.errors.ConfigError` for an unknown name
        or an invalid value.
        """
        return with_values(self, values, "fault")

    @property
    def trajectory(self) -> str:
        """The trajectory of a :class:`~mapper.simulation.recording.Recording` that the map is made with."""
        if not self.drift:
            return "true"
        return "slam" if self.slam else "odometry"

    @property
    def corrects_poses(self) -> bool:
        """Whether the map is made with corrected poses."""
        return self.trajectory == "slam"


@lru_cache(maxsize=16)
def polished_faces(world: World) -> Float64Array:
    """Return the faces (n, 4), ``(ax, ay, bx, by)`` in metres, that are polished: all straight ones that are long."""
    length = np.hypot(*(world.seen[:, 2:] - world.seen[:, :2]).T)
    faces: Float64Array = np.ascontiguousarray(world.seen[length >= POLISHED_LENGTH])
    faces.setflags(write=False)
    return faces


def reflected_away(world: World, ranges: ArrayLike, angles: ArrayLike, sensor_pose: ArrayLike) -> NDArray[np.bool_]:
    """Return which beams (n,) a polished wall reflects away, given their true ``ranges`` (n,), without noise.

    ``angles`` (n,) are radians in the laser frame, ``sensor_pose`` (3,) is ``T_map_laser``. A beam that returns from
    anything else, or from nothing, is not reflected away. Source of the effect: Probabilistic Robotics, section 6.3
    (failures of a range finder: specular reflection, of sonars on every smooth wall, of lidars on glass and polished
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
    """Return by how many metres (n_readings,) each reading is longer because of the polished walls.

    0 where the reading is the true one, +inf where nothing comes back any more; ``sensor_pose`` (3,) is
    ``T_map_laser``. A lidar's beam returns or it does not. A sonar hears the nearest wall in its cone that it meets
    within :data:`SPECULAR_ANGLE` of the normal, and whatever is not polished. Half precision, a thousandth of the
    distance, is less than any sensor's noise.
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
    """Return readings, of any shape, as the sensor reports them near polished walls: see :func:`lengthened`.

    What is longer than ``range_max`` does not return: +inf (REP 117).
    """
    reported = ranges + longer
    reported[reported > range_max] = np.inf
    return reported
