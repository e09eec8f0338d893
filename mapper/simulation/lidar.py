"""Simulated range finder, a rotating lidar or a ring of sonars: parameters, and readings in a world."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.core.parameter import check_fields, choice, number, table_of, with_values
from mapper.sensors.scan import LaserScan
from mapper.simulation.kernels.lidar import add_noise, cast_rays
from mapper.simulation.robot import PoseTuple
from mapper.simulation.worlds import World

RAY_STEP = math.radians(1.0)  #: between the rays that sample a cone


def rays_of_cone(beam_width: float) -> Float64Array:
    """Return the bearings (n_rays,) relative to a cone's axis, radians, of the rays that sample it.

    They are at most :data:`RAY_STEP` apart and include the cone's edges and its axis; ``beam_width`` is from edge to
    edge.
    """
    n_rays = 2 * math.ceil(beam_width / 2.0 / RAY_STEP) + 1
    return np.linspace(-beam_width / 2.0, beam_width / 2.0, n_rays)


def ranges_in_cones(
    world: World, pose: tuple[float, float, float], bearings: Float64Array, beam_width: float, range_max: float
) -> Float64Array:
    """Return the distance (n, n_rays), metres, along each ray of each cone to the first solid, +inf if there is none.

    ``pose`` (x, y, yaw) is ``T_map_sensor``; ``bearings`` (n,) of the cones' axes and ``beam_width`` are radians; the
    rays are those of :func:`rays_of_cone`. A sonar measures the nearest surface that returns an echo. Source: the wide
    beam of a time of flight sonar, Moravec & Elfes 1985.
    """
    x, y, yaw = pose
    rays = rays_of_cone(beam_width)
    out = np.empty((len(bearings), len(rays)))
    for k, bearing in enumerate(bearings.tolist()):
        cast_rays(world.seen, x, y, yaw, bearing + rays[0], rays[1] - rays[0], range_max, out[k])
    return out


TURN = 2.0 * np.pi
RANGE_MIN = 0.02  #: metres: lower limit of readings, whatever the noise


@dataclass(frozen=True, slots=True)
class SensorConfig:
    """Values of all rows of :data:`SENSOR_PARAMETERS`; each field states its unit and meaning.

    Raises :class:`ConfigError` naming the invalid field.
    """

    # fmt: off
    kind: str = choice(
        "Sensor", "sensor", "lidar",
        "A lidar has many thin beams; a sonar measures the nearest object in a cone, without its bearing.",
        ("lidar", "sonar_ring"),
    )
    n_beams: int = number(
        "Beams", "sensor", 360, "Beams in each scan, spread evenly over the field of view.",
        "", 30, 1080, 30, only_for=("lidar",),
    )
    n_sonars: int = number(
        "Sonars", "sensor", 16, "Sonars of the ring, spread evenly over the field of view.",
        "", 4, 48, 1, only_for=("sonar_ring",),
    )
    beam_width: float = number(
        "Sonar cone angle", "sensor", 0.35, "The angle, from edge to edge, in which a sonar hears an echo.",
        "rad", 0.05, 1.0, 0.01, only_for=("sonar_ring",),
    )
    field_of_view: float = number(
        "Field of view", "sensor", TURN, "The angle that a scan covers, centred straight ahead.",
        "rad", TURN / 12, TURN, TURN / 72,
    )
    range_max: float = number(
        "Sensor range", "sensor", 10.0,
        "The farthest the sensor can measure; a beam that meets nothing nearer returns nothing.", "m", 1.0, 30.0, 0.5,
    )
    range_noise: float = number(
        "Range noise σ", "sensor", 0.01, "Standard deviation of a reading about the true range.", "m", 0.0, 0.5, 0.005,
    )
    scan_rate: float = number("Scan rate", "sensor", 10.0, "Scans in a second.", "Hz", 1.0, 25.0, 1.0)
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)
        for name, label in (("n_beams", "Beams"), ("n_sonars", "Sonars")):
            value = getattr(self, name)
            if value != int(value):
                raise ConfigError(f"parameter.{name}", f"{label} ({name}) must be a whole number, not {value!r}.")
            object.__setattr__(self, name, int(value))

    @property
    def n_readings(self) -> int:
        """Readings per scan: one per lidar beam or sonar."""
        return self.n_beams if self.kind == "lidar" else self.n_sonars

    @property
    def cone(self) -> float:
        """The angle in which a reading may originate, radians: 0 for the lidar's thin beams."""
        return 0.0 if self.kind == "lidar" else self.beam_width

    @property
    def angle_increment(self) -> float:
        """Radians between beams. A full turn has no beam twice; a narrower fan has one at each edge."""
        return self.field_of_view / (self.n_readings if self.field_of_view >= TURN else self.n_readings - 1)

    @property
    def angle_min(self) -> float:
        """Bearing of the first beam in the laser frame, radians."""
        return -self.field_of_view / 2.0

    @property
    def bearings(self) -> Float64Array:
        """Bearings of the readings (n_readings,) in the laser frame, radians."""
        return _bearings(self.angle_min, self.angle_increment, self.n_readings)

    @property
    def directions(self) -> Float64Array:
        """Cosine and sine (n_readings, 2) of :attr:`bearings`."""
        return _directions(self.angle_min, self.angle_increment, self.n_readings)

    def with_values(self, values: Mapping[str, Any]) -> SensorConfig:
        """Return a copy with some values replaced. Raise :class:`ConfigError` for an unknown name or an invalid
        value.
        """
        return with_values(self, values, "sensor parameter")


SENSOR_PARAMETERS = table_of(SensorConfig)


@lru_cache(maxsize=64)
def _bearings(angle_min: float, angle_increment: float, count: int) -> Float64Array:
    """Return evenly spaced bearings (count,), radians, shared by all scans of one sensor."""
    bearings: Float64Array = angle_min + angle_increment * np.arange(count, dtype=np.float64)
    bearings.setflags(write=False)
    return bearings


@lru_cache(maxsize=64)
def _directions(angle_min: float, angle_increment: float, count: int) -> Float64Array:
    bearings = _bearings(angle_min, angle_increment, count)
    directions: Float64Array = np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)
    directions.setflags(write=False)
    return directions


def pose_of(numbers: ArrayLike) -> PoseTuple:
    """Return a pose (3,) as a tuple of floats."""
    if isinstance(numbers, tuple):
        return cast("PoseTuple", numbers)
    x, y, yaw = np.asarray(numbers, dtype=np.float64).tolist()
    return (x, y, yaw)


def true_ranges(world: World, sensor: SensorConfig, sensor_pose: PoseTuple) -> Float64Array:
    """Return the exact distance (n_readings,), metres, from ``sensor_pose``, ``T_map_laser``, to the first solid.

    +inf if a beam, or a sonar's cone, hits nothing within ``sensor.range_max``. The array may be shared and must not be
    modified.
    """
    x, y, yaw = sensor_pose
    if sensor.kind == "sonar_ring":
        heard = ranges_in_cones(world, (x, y, yaw), sensor.bearings, sensor.beam_width, sensor.range_max)
        nearest: Float64Array = heard.min(axis=1)
        return nearest
    return _thin_ranges(world, sensor, x, y, yaw)


@lru_cache(maxsize=128)  # requested for a scan and then for its polished walls
def _thin_ranges(world: World, sensor: SensorConfig, x: float, y: float, yaw: float) -> Float64Array:
    out = np.empty(sensor.n_readings)
    cast_rays(world.seen, x, y, yaw, sensor.angle_min, sensor.angle_increment, sensor.range_max, out)
    return out


def measure(
    world: World, sensor: SensorConfig, sensor_pose: ArrayLike, rng: np.random.Generator, stamp_ns: int = 0
) -> LaserScan:
    """Return the scan reported by the sensor at ``sensor_pose`` (3,), ``T_map_laser``, with all beams at one instant.

    Each true range has Gaussian noise of σ = ``range_noise``, limited so that no reading is below :data:`RANGE_MIN`;
    one beyond ``range_max``, before or after the noise, is +inf, "no return" (REP 117). This is p_hit of the beam model
    (Probabilistic Robotics, table 6.1) without its other three terms.
    """
    # Drawn even for σ = 0, so that the noise of later scans does not depend on σ.
    noise = rng.standard_normal(sensor.n_readings)
    ranges = np.empty(sensor.n_readings, dtype=np.float32)
    true = true_ranges(world, sensor, pose_of(sensor_pose))
    add_noise(true, noise, sensor.range_noise, RANGE_MIN, sensor.range_max, ranges)
    limits = (RANGE_MIN, sensor.range_max)
    return LaserScan(ranges, sensor.angle_min, sensor.angle_increment, *limits, stamp_ns, sensor.cone)
