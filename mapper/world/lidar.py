"""A rotating lidar: its parameters, and what it reads in a world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mapper.errors import ConfigError
from mapper.kernels.raycast import cast_rays
from mapper.parameters import Parameter
from mapper.scan import LaserScan
from mapper.world.worlds import Float64Array, World

TURN = 2.0 * np.pi
RANGE_MIN = 0.02  #: metres: no reading is shorter, whatever the noise

SENSOR_PARAMETERS: tuple[Parameter, ...] = (
    Parameter(
        "n_beams", "Beams", "sensor", "number", 360,
        "Beams in each scan, spread evenly over the field of view.",
        low=30, high=1080, step=30,
    ),
    Parameter(
        "field_of_view", "Field of view", "sensor", "number", TURN,
        "The angle that a scan covers, centred straight ahead.",
        unit="rad", low=TURN / 12, high=TURN, step=TURN / 72,
    ),
    Parameter(
        "range_max", "Sensor range", "sensor", "number", 10.0,
        "The farthest the sensor can measure; a beam that meets nothing nearer returns nothing.",
        unit="m", low=1.0, high=30.0, step=0.5,
    ),
    Parameter(
        "range_noise", "Range noise σ", "sensor", "number", 0.01,
        "Standard deviation of a reading about the true range.",
        unit="m", low=0.0, high=0.5, step=0.005,
    ),
    Parameter(
        "scan_rate", "Scan rate", "sensor", "number", 10.0,
        "Scans in a second.",
        unit="Hz", low=1.0, high=25.0, step=1.0,
    ),
)  # fmt: skip

BY_NAME: Mapping[str, Parameter] = {row.name: row for row in SENSOR_PARAMETERS}


@dataclass(frozen=True, slots=True)
class SensorConfig:
    """One value for each row of :data:`SENSOR_PARAMETERS`; units and meanings stand there.

    Raises :class:`ConfigError` naming the field that is refused.
    """

    n_beams: int = 360
    field_of_view: float = TURN
    range_max: float = 10.0
    range_noise: float = 0.01
    scan_rate: float = 10.0

    def __post_init__(self) -> None:
        for row in SENSOR_PARAMETERS:
            object.__setattr__(self, row.name, row.check(getattr(self, row.name)))
        if self.n_beams != int(self.n_beams):
            raise ConfigError("parameter.n_beams", f"Beams (n_beams) must be a whole number, not {self.n_beams!r}.")
        object.__setattr__(self, "n_beams", int(self.n_beams))

    @property
    def angle_increment(self) -> float:
        """Radians from one beam to the next. A full turn has no beam twice; a narrower fan has one at each edge."""
        return self.field_of_view / (self.n_beams if self.field_of_view >= TURN else self.n_beams - 1)

    @property
    def angle_min(self) -> float:
        """Bearing of the first beam in the laser frame, radians."""
        return -self.field_of_view / 2.0

    def with_values(self, values: Mapping[str, Any]) -> SensorConfig:
        """Return a copy with some values replaced; raise :class:`ConfigError` for an unknown name or a bad value."""
        unknown = [name for name in values if name not in BY_NAME]
        if unknown:
            raise ConfigError("parameter.unknown", f"There is no sensor parameter {unknown[0]!r:.80}.")
        return SensorConfig(**(asdict(self) | dict(values)))


if {f.name: f.default for f in fields(SensorConfig)} != {row.name: row.initial for row in SENSOR_PARAMETERS}:
    raise AssertionError("SensorConfig and SENSOR_PARAMETERS must name the same parameters with the same first values")


def true_ranges(world: World, sensor: SensorConfig, sensor_pose: ArrayLike) -> Float64Array:
    """Return the exact distance (n_beams,), metres, from ``sensor_pose`` (3,), ``T_map_laser``, to the first solid.

    +inf where a beam meets nothing within ``sensor.range_max``.
    """
    x, y, yaw = (float(v) for v in np.asarray(sensor_pose, dtype=np.float64))
    out = np.empty(sensor.n_beams)
    cast_rays(world.segments, x, y, yaw, sensor.angle_min, sensor.angle_increment, sensor.range_max, out)
    return out


def measure(
    world: World, sensor: SensorConfig, sensor_pose: ArrayLike, rng: np.random.Generator, stamp_ns: int = 0
) -> LaserScan:
    """Return the scan that the lidar at ``sensor_pose`` (3,), ``T_map_laser``, reports, all beams at one instant.

    Each true range gets Gaussian noise of σ = ``range_noise``, cut off so that no reading falls below
    :data:`RANGE_MIN`; one beyond ``range_max``, before or after the noise, is +inf, "no return" (REP 117). This is
    p_hit of the beam model (Probabilistic Robotics, table 6.1) without its other three terms.
    """
    noise = rng.standard_normal(
        sensor.n_beams
    )  # drawn even where σ = 0: the noise of later scans does not depend on it
    ranges = np.maximum(true_ranges(world, sensor, sensor_pose) + sensor.range_noise * noise, RANGE_MIN).astype(
        np.float32
    )
    ranges[ranges > sensor.range_max] = np.inf
    return LaserScan(ranges, sensor.angle_min, sensor.angle_increment, RANGE_MIN, sensor.range_max, stamp_ns)
