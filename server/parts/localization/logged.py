"""The localization of a log in a reference map: the map, the particles and the estimates over time."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct, structs

from mapper.core.errors import ConfigError
from mapper.io.maps.reading import grid_of_values
from mapper.mapping.parameters import MappingConfig
from server.library.packs.filter_states import FilterStates, read_filter_states
from server.library.packs.reference_map import ReferenceMap
from server.parts.localization.messages import (
    COLUMNS,
    OFF,
    LocalizationMessage,
    rounded_covariance,
    rounded_pose,
)
from server.sessions.commands import PosesEnded, PosesSoFar, ShowFilterStates, ShowReferenceMap
from server.sessions.hosting import ModelHost
from server.sessions.part import Part, Plan, StaticMap
from server.sessions.parts import FilterHistory, GraphSource, Localized, Recording
from server.sessions.tick import TickResult
from server.stream.grid_layer import GridLayer
from server.stream.layers import Layer, TableLayer

if TYPE_CHECKING:
    from server.library.processing.localization import LocalizeProgress

LOCALIZED = "localized"  #: the trajectory of poses from localization
MOST_POINTS = 1000  #: of the series that pages plot


class LogLocalization(Part, Localized):
    """View of a running localization job, and of a trajectory from one."""

    commands = (ShowReferenceMap, ShowFilterStates)
    is_on = False  # until there is a map or a job to show

    def __init__(self, host: ModelHost, recording: Recording) -> None:
        self._host, self._recording = host, recording
        self._changing = asyncio.Lock()  #: held while a file is read
        self._newest: tuple[str, FilterStates] | None = None  #: which the model may not show yet
        self._shown: tuple[str, FilterStates] | None = None
        self._report: LocalizeProgress | None = None
        self._drawn: tuple[FilterStates, int] | None = None  #: the states and the scan of the particles in the layer
        self._given: ReferenceMap | None = None
        self._map: GridLayer | None = None
        self._particles = TableLayer("particles", "Particles", "particles", COLUMNS)

    # -- on a worker thread ---------------------------------------------------------------------------------------

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The reference map, and the particles if there are any."""
        is_on = self._report is not None or self._states is not None
        maps = () if self._map is None else (self._map,)
        return (*maps, self._particles) if is_on else maps

    @property
    def cells(self) -> int:
        """Cells of the reference map."""
        return 0 if self._given is None else int(self._given.values.size)

    @property
    def _states(self) -> FilterStates | None:
        """The states of the filter along the trajectory in use."""
        shown = self._shown
        return shown[1] if shown is not None and shown[0] == self._recording.trajectory else None

    @property
    def plan(self) -> Plan:
        """The map in which the log is localized, as a plan for parts. Localized poses are in its frame."""
        return Plan(
            "the map of the group Localize, for poses in that map",
            self._static_map,
            lambda: self._given,
            lambda: self._given is not None and self._recording.trajectory == LOCALIZED,
        )

    def _static_map(self) -> StaticMap:
        reference = self._given
        if reference is None:
            raise ConfigError("costmap.no_given_map", "There is no reference map: choose one in the group Localize.")
        return StaticMap(grid_of_values(reference.geometry, reference.values), reference.keepout, reference.speed)

    def handle(self, command: ShowReferenceMap | ShowFilterStates, result: TickResult) -> None:
        """Show a map, or the filter states of a trajectory."""
        result.changed = True
        if isinstance(command, ShowFilterStates):
            self._shown = (command.trajectory, command.states)
            self._drawn = None
            self.show_map(command.states.reference)
        else:
            self.show_map(command.map)

    def show_map(self, reference: ReferenceMap) -> None:
        """Write a map into its layer."""
        self._given, self.is_on = reference, True
        self._map = self._map or GridLayer("given_map", "Map to localize in")
        grid = grid_of_values(reference.geometry, reference.values)
        self._map.update(grid, MappingConfig(), None, whole=True)

    def note(self, command: Struct, result: TickResult) -> None:
        """Show the newest report of a running job, until it ends."""
        if isinstance(command, PosesSoFar) and command.report is not None:
            self._report, self.is_on = command.report, True
            self._particles.set(self._report.particles.T)
            result.slot(self.message())
        elif isinstance(command, PosesEnded):
            self._report = self._drawn = None
            result.slot(self.message())

    def changed(self, result: TickResult) -> None:
        """Show the particles of the newest scan."""
        states, scan = self._states, max(self._recording.replay.index - 1, 0)
        drawn, at = self._drawn or (None, scan)
        if self._report is not None or (drawn is states and at == scan):
            return
        self._drawn = None if states is None else (states, scan)
        result.changed = True
        if states is None:
            result.slot(OFF)
            return
        cloud = states.cloud(scan)
        self._particles.set(np.vstack([cloud.T, np.ones((1, len(cloud)), dtype=np.float32)]))
        result.slot(self.message())

    def messages(self) -> list[LocalizationMessage]:
        """Return the ``localization`` message."""
        return [self.message()]

    def message(self) -> LocalizationMessage:
        """Return the ``localization`` message."""
        if self._report is not None:
            report = self._report
            covariance, pose = report.covariance, rounded_pose(report.poses[-1])
            numbers = (
                report.is_converged, report.is_sure, report.share, report.fit, report.entropy, report.n_particles,
            )  # fmt: skip
            updates = report.n_updates
        elif (states := self._states) is not None:
            recording = self._recording
            scan = max(recording.replay.index - 1, 0)
            covariance = states.covariance[scan]
            pose = rounded_pose(recording.log.trajectory(recording.trajectory).poses[scan])
            numbers = (
                bool(states.is_converged[scan]), bool(states.is_sure[scan]), float(states.share[scan]),
                float(states.fit[scan]), float(states.entropy[scan]), int(states.n_particles[scan]),
            )  # fmt: skip
            updates = int(np.count_nonzero(states.is_updated[: scan + 1]))
        else:
            return OFF
        is_converged, is_sure, share, fit, entropy, n_particles = numbers
        return structs.replace(
            OFF,
            is_on=True,
            pose=pose,
            at=pose,
            covariance=rounded_covariance(covariance),
            is_converged=is_converged,
            is_sure=is_sure,
            share=round(share, 4),
            fit=round(fit, 4),
            entropy=round(entropy, 3),
            n_particles=n_particles,
            n_updates=updates,
        )

    # -- on the event loop ----------------------------------------------------------------------------------------

    async def public(self, source: GraphSource) -> FilterHistory | None:
        """Return the series of the current trajectory, None if it does not come from localization; show its layers.

        ``source`` reads its file. Raises :class:`mapper.core.errors.ReadError` if the file cannot be read.
        """
        async with self._changing:
            name = self._recording.trajectory
            if self._newest is None or self._newest[0] != name:
                data = await source(name)
                if data is None:
                    return None
                states = await self._host.on_thread(partial(read_filter_states, data))
                if len(states.share) != self._recording.log.n_scans:
                    return None  # it belongs to the scans of another sensor
                self._newest = (name, states)
            states = self._newest[1]
            if self._shown is not self._newest:
                self._host.enqueue(ShowFilterStates(name, states))
            return await self._host.on_thread(partial(series_of, states, self._recording.recorded))

    def forget(self) -> None:
        """Reread the file on the next request, because its trajectory was replaced."""
        self._newest = None


def series_of(states: FilterStates, seconds: np.ndarray[Any, Any]) -> FilterHistory:
    """Return the numbers over the log's ``seconds`` (n,); of a long log, every k-th scan."""
    n = len(states.share)
    at = np.unique(np.linspace(0, n - 1, min(n, MOST_POINTS)).round().astype(int))
    xy = np.trace(states.covariance[at, :2, :2], axis1=1, axis2=2)
    converged = np.flatnonzero(states.is_converged)
    return FilterHistory(
        map=states.reference.public(),
        scans=at.tolist(),
        seconds=np.round(seconds[at], 2).tolist(),
        entropy=np.round(states.entropy[at], 3).tolist(),
        deviation_m=np.round(np.sqrt(np.maximum(xy, 0.0)), 4).tolist(),
        fit=np.round(states.fit[at], 4).tolist(),
        is_converged=states.is_converged[at].tolist(),
        n_particles=states.n_particles[at].tolist(),
        first_converged=int(converged[0]) if len(converged) else None,
    )
