"""The localization of a simulation while it is on: begun, changed and ended by commands, and what is shown of it."""

from __future__ import annotations

from msgspec import Struct

from mapper.simulation.live_map import LiveMap
from server.parts.localization.live_filter import LabLocalization
from server.parts.localization.messages import OFF, LocalizationMessage, LocalizeCommand
from server.sessions.part import Part
from server.sessions.tick import TickResult
from server.stream.commands import RestartCommand, SensorCommand, TeleportCommand, WorldCommand
from server.stream.layers import Layer


class LocalizationView(Part):
    """The filter of the simulated robot, if there is one."""

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
        """Cells of the grids that it holds."""
        return 0 if self._filter is None else self._filter.cells

    def messages(self) -> list[LocalizationMessage]:
        """Return the message ``localization``."""
        return [self.message()]

    def message(self) -> LocalizationMessage:
        """Return the message ``localization``."""
        return OFF if self._filter is None else self._filter.message()

    def handle(self, command: LocalizeCommand, result: TickResult) -> None:
        """Begin to localize the robot in a plan of the present world, change the parameters, or end it.

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
        """Let the filter see the newest scan."""
        mapper, scan = self._mapper, self._mapper.newest
        if self._filter is None or scan is None or mapper.hidden:
            return
        if self._filter.look(scan, mapper.newest_pose):
            result.changed = True
            result.slot(self.message())

    def note(self, command: Struct, result: TickResult) -> None:
        """End with another sensor or world; of a robot that was carried elsewhere the filter is not told."""
        if self._filter is None:
            return
        if isinstance(command, TeleportCommand):
            self._filter.note_teleport(self._mapper.newest_pose)
        elif isinstance(command, SensorCommand | WorldCommand | RestartCommand):
            self._filter, self.is_on = None, False
            result.slot(OFF)
