"""Localization of the simulated robot in a reference map: its filter, its display, and its error."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from msgspec import Struct

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.localization import LocalizationConfig, MonteCarloLocalizer
from mapper.localization.likelihood_field import beam_likelihood
from mapper.localization.map_model import map_model
from mapper.localization.scan_beams import limits_of, scan_beams
from mapper.sensors.scan import RangeScan
from mapper.simulation.floor_plans import another_world
from mapper.simulation.lidar import RANGE_MIN, SensorConfig
from mapper.simulation.live_map import LiveMap
from mapper.simulation.odometry import Odometer
from mapper.simulation.plan_map import plan_map, with_moved_furniture
from mapper.simulation.robot import PoseTuple
from mapper.simulation.worlds import World
from server.parts.localization.messages import (
    COLUMNS,
    OFF,
    LocalizationMessage,
    LocalizeCommand,
    rounded_covariance,
    rounded_pose,
)
from server.sessions.part import Part
from server.sessions.tick import TickResult
from server.stream.commands import RestartCommand, SensorCommand, TeleportCommand, WorldCommand
from server.stream.grid_layer import GridLayer
from server.stream.layers import Layer, TableLayer

MOST_SHOWN = 10_000  #: particles sent to pages
MOST_PARTICLES = 100_000  #: maximum for one session
SEED = 16


#: The maps of the world that a filter may use.
MAPS: Mapping[str, Callable[[World], World]] = {
    "plan": lambda world: world,
    "moved": with_moved_furniture,
    "other": lambda world: another_world(world.name),
}


class LabLocalization:
    """A filter that uses a plan of the world as it was at the start, odometry with errors, and the scans.

    It does not know of teleports, see :meth:`note_teleport`. ``message`` is what the page shows of it.
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
        """Start at ``pose`` without passing it to the filter. ``given`` names one of :data:`MAPS`.

        Raises :class:`ConfigError` for invalid values.
        """
        if given not in MAPS:
            raise ConfigError("localization.map", f"The map must be one of {', '.join(MAPS)}, not {given!r:.80}.")
        self.given = given
        self._plan = plan_map(MAPS[given](world))
        self._range_max = sensor.range_max
        config = self._take(values)
        self._filter = MonteCarloLocalizer(
            map_model(self._plan, config, self._longest(config)),
            config,
            range_min=RANGE_MIN,
            range_max=sensor.range_max,
            mount=mount,
            seed=SEED,
        )  # fmt: skip
        self._odometer = Odometer(pose, np.random.default_rng(SEED))
        self._seen: RangeScan | None = None
        self._true = pose
        self._particles = TableLayer("particles", "Particles", "particles", COLUMNS)
        self._field = GridLayer("likelihood_field", "Likelihood field", "likelihood_field")
        self._draw_field()
        self._draw(*self._filter.weighed)

    def _take(self, values: Mapping[str, Any]) -> LocalizationConfig:
        """Return the parameters with ``values`` replaced. Raises :class:`ConfigError` for invalid values."""
        config = LocalizationConfig(global_particles=20_000).with_values(values)
        fewer = {
            name: min(getattr(config, name), MOST_PARTICLES)
            for name in ("min_particles", "max_particles", "global_particles")
        }
        self.values = dict(values)
        return config.with_values(fewer)

    def _longest(self, config: LocalizationConfig) -> float:
        return limits_of(config, RANGE_MIN, self._range_max)[1]

    def change(self, values: Mapping[str, Any]) -> None:
        """Change the parameters. The particles are kept, with the weights that the newest scan now gives them.

        Raises :class:`ConfigError` for invalid values; nothing has changed then.
        """
        before = self.values
        try:
            config = self._take(values)
            model = map_model(self._plan, config, self._longest(config))
        except ConfigError:
            self.values = before
            raise
        self._filter.reconfigure(config, model)
        self._draw_field()
        poses, weights = self._filter.weighed
        if self._seen is not None:
            beams = scan_beams(self._seen, self._filter.mount, config)
            weights = self._filter.weights_by(beams) if len(beams.points) else weights
        self._draw(poses, weights)

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The particles, and the likelihood field."""
        return (self._particles, self._field)

    @property
    def cells(self) -> int:
        """Number of cells of its grids."""
        return 3 * self._filter.model.geometry.rows * self._filter.model.geometry.cols

    def note_teleport(self, pose: PoseTuple) -> None:
        """Record that the robot was moved to ``pose`` without its wheels turning."""
        self._odometer.carry(pose)
        self._true = pose

    def look(self, scan: RangeScan, pose: PoseTuple) -> bool:
        """Use a scan, unless it was used before, at the true ``pose``; return whether anything has changed."""
        if scan is self._seen:
            return False
        self._seen, self._true = scan, pose
        estimate = self._filter.update(self._odometer.move(pose), scan)
        if estimate.is_updated:
            self._draw(*self._filter.weighed)
        return True

    def _draw_field(self) -> None:
        """Write the likelihood of a reading that ends in each cell into its layer."""
        config, model = self._filter.config, self._filter.model
        longest = self._longest(config)
        likelihood = beam_likelihood(model.field.distances, config, longest)
        self._field.set(model.geometry, likelihood.astype(np.float32), 0.0, config.z_hit + config.z_rand / longest)

    def _draw(self, particles: Float64Array, weights: Float64Array) -> None:
        """Write particles (n, 3) into their layer, coloured by their weights (n,)."""
        step = -(-len(particles) // MOST_SHOWN)
        value = weights[::step] / weights.max()
        self._particles.set(np.vstack([particles[::step].T, value[np.newaxis]]))

    def message(self) -> LocalizationMessage:
        """Return the ``localization`` message."""
        estimate, model = self._filter.estimate, self._filter
        off = estimate.pose[:2] - np.array(self._true[:2])
        turned = math.remainder(float(estimate.pose[2]) - self._true[2], math.tau)
        return LocalizationMessage(
            is_on=True,
            map=self.given,
            values=self.values,
            pose=rounded_pose(estimate.pose),
            at=rounded_pose(self._true),
            covariance=rounded_covariance(estimate.covariance),
            is_converged=estimate.is_converged,
            is_sure=estimate.is_sure,
            share=round(estimate.share, 4),
            fit=round(estimate.fit, 4),
            entropy=round(estimate.entropy, 3),
            n_particles=len(model.particles),
            n_updates=model.n_updates,
            error_m=round(math.hypot(*off), 4),
            error_rad=round(abs(turned), 4),
        )


class LocalizationView(Part):
    """The filter of the simulated robot, if any."""

    commands = (LocalizeCommand,)
    subject = "localization"
    is_on = False

    def __init__(self, mapper: LiveMap) -> None:
        self._mapper = mapper
        self._filter: LabLocalization | None = None

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The particles and the likelihood field while it is on."""
        return () if self._filter is None else self._filter.layers

    @property
    def cells(self) -> int:
        """Number of cells of its grids."""
        return 0 if self._filter is None else self._filter.cells

    def messages(self) -> list[LocalizationMessage]:
        """Return the ``localization`` message."""
        return [self.message()]

    def message(self) -> LocalizationMessage:
        """Return the ``localization`` message."""
        return OFF if self._filter is None else self._filter.message()

    def handle(self, command: LocalizeCommand, result: TickResult) -> None:
        """Start localizing the robot in a plan of the current world, change the parameters, or end it.

        Raises :class:`mapper.core.errors.ConfigError`; nothing has changed then.
        """
        if not command.value:
            self._filter = None
        elif command.keep and self._filter is not None and self._filter.given == command.map:
            self._filter.change(command.values)
        else:
            mapper, simulation = self._mapper, self._mapper.simulation
            self._filter = LabLocalization(
                simulation.world, simulation.sensor, simulation.mount, mapper.newest_pose, command.values, command.map
            )
        self.is_on = self._filter is not None
        result.changed = True
        result.slot(self.message())

    def changed(self, result: TickResult) -> None:
        """Pass the newest scan to the filter."""
        mapper, scan = self._mapper, self._mapper.newest
        if self._filter is None or scan is None or mapper.hidden:
            return
        if self._filter.look(scan, mapper.newest_pose):
            result.changed = True
            result.slot(self.message())

    def note(self, command: Struct, result: TickResult) -> None:
        """End if the sensor or the world changes. The filter is not informed that the robot was moved."""
        if self._filter is None:
            return
        if isinstance(command, TeleportCommand):
            self._filter.note_teleport(self._mapper.newest_pose)
        elif isinstance(command, SensorCommand | WorldCommand | RestartCommand):
            self._filter, self.is_on = None, False
            result.slot(OFF)
