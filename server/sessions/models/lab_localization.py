"""Localization of the simulated robot in a given map: its filter, what it is shown by, and how far off it is."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from mapper.core.errors import ConfigError
from mapper.localization import LocalizationConfig, MonteCarloLocalizer
from mapper.localization.likelihood_field import beam_likelihood
from mapper.localization.scan_beams import limits_of
from mapper.sensors.scan import RangeScan
from mapper.simulation.changed_plan import with_moved_furniture
from mapper.simulation.floor_plans import another_world
from mapper.simulation.lidar import RANGE_MIN, SensorConfig
from mapper.simulation.odometry import Odometer
from mapper.simulation.plan_map import plan_map
from mapper.simulation.robot import PoseTuple
from mapper.simulation.worlds import World
from server.sessions.models.localization_message import COLUMNS
from server.stream.layers import GridLayer, Layer, TableLayer

MOST_SHOWN = 10_000  #: particles that are sent
MOST_PARTICLES = 100_000  #: that one session may have
SEED = 16


#: The maps that a filter may be given of the world.
MAPS: Mapping[str, Callable[[World], World]] = {
    "plan": lambda world: world,
    "moved": with_moved_furniture,
    "other": lambda world: another_world(world.name),
}


class LabLocalization:
    """A filter that is given a plan of the world as it was when it began, odometry with errors, and the scans.

    It is not told of teleports: :meth:`carried`. ``message`` is what the page shows of it.
    """

    def __init__(
        self,
        world: World,
        sensor: SensorConfig,
        mount: tuple[float, float, float],
        pose: PoseTuple,
        values: Mapping[str, Any],
        given: str = "plan",
    ) -> None:
        """Begin at ``pose`` without telling it to the filter; ``given`` names one of :data:`MAPS`.

        Raises :class:`ConfigError` for values it refuses.
        """
        if given not in MAPS:
            raise ConfigError("localization.map", f"The map must be one of {', '.join(MAPS)}, not {given!r:.80}.")
        self.values, self.given = dict(values), given
        config = LocalizationConfig(global_particles=20_000).with_values(values)
        most = max(config.global_particles, config.max_particles)
        if most > MOST_PARTICLES:
            config = config.with_values(
                {
                    "global_particles": min(config.global_particles, MOST_PARTICLES),
                    "max_particles": min(config.max_particles, MOST_PARTICLES),
                }
            )
        self._filter = MonteCarloLocalizer(
            plan_map(MAPS[given](world)),
            config,
            range_min=RANGE_MIN,
            range_max=sensor.range_max,
            mount=mount,
            seed=SEED,
        )  # fmt: skip
        self._config = config
        self._odometer = Odometer(pose, np.random.default_rng(SEED))
        self._seen: RangeScan | None = None
        self._true = pose
        self._particles = TableLayer("particles", "Particles", "particles", COLUMNS)
        self._field = GridLayer("likelihood_field", "Likelihood field", "likelihood_field")
        model = self._filter.model
        _, longest = limits_of(config, RANGE_MIN, sensor.range_max)
        likelihood = beam_likelihood(model.field.distances, config, longest)
        greatest = config.z_hit + config.z_rand / longest
        self._field.set(model.geometry, likelihood.astype(np.float32), 0.0, greatest)
        self._draw()

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The particles, and the likelihood field."""
        return (self._particles, self._field)

    @property
    def cells(self) -> int:
        """Cells of the grids that it holds."""
        return 3 * self._filter.model.geometry.rows * self._filter.model.geometry.cols

    def carried(self, pose: PoseTuple) -> None:
        """Note that the robot was carried to ``pose``: its wheels did not turn."""
        self._odometer.carry(pose)
        self._true = pose

    def look(self, scan: RangeScan, pose: PoseTuple) -> bool:
        """Take a scan, unless it was taken before, at the true ``pose``; return whether there is something new."""
        if scan is self._seen:
            return False
        self._seen, self._true = scan, pose
        found = self._filter.update(self._odometer.move(pose), scan)
        if found.is_updated:
            self._draw()
        return True

    def _draw(self) -> None:
        particles, weights = self._filter.particles, self._filter.weights
        step = -(-len(particles) // MOST_SHOWN)
        value = weights[::step] / weights.max()
        self._particles.set(np.vstack([particles[::step].T, value[np.newaxis]]))

    def message(self) -> dict[str, Any]:
        """Return the message ``localization``."""
        found, model = self._filter.estimate, self._filter
        off = found.pose[:2] - np.array(self._true[:2])
        turned = math.remainder(float(found.pose[2]) - self._true[2], math.tau)
        c = found.covariance
        return {
            "type": "localization",
            "is_on": True,
            "map": self.given,
            "values": self.values,
            "pose": [round(float(v), 4) for v in found.pose],
            "at": [round(v, 4) for v in self._true],
            "covariance": [round(float(v), 6) for v in (c[0, 0], c[0, 1], c[1, 1], c[2, 2])],
            "is_converged": found.is_converged,
            "share": round(found.share, 4),
            "fit": round(found.fit, 4),
            "entropy": round(found.entropy, 3),
            "n_particles": len(model.particles),
            "n_updates": model.n_updates,
            "error_m": round(math.hypot(*off), 4),
            "error_rad": round(abs(turned), 4),
        }
