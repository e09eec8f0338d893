"""The localization of a simulation while it is on: begun, changed and ended by commands, and what is shown of it."""

from __future__ import annotations

from typing import Any

from mapper.simulation.live_map import LiveMap
from mapper.simulation.robot import PoseTuple
from server.sessions.models.lab_localization import LabLocalization
from server.sessions.models.localization_message import OFF
from server.sessions.models.simulation_commands import flag
from server.sessions.tick import TickResult
from server.stream.layers import Layer
from server.stream.protocol import text, values


class LocalizationView:
    """The filter of the simulated robot, if there is one."""

    def __init__(self) -> None:
        self._one: LabLocalization | None = None

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The particles and the likelihood field while it is on."""
        return () if self._one is None else self._one.layers

    @property
    def cells(self) -> int:
        """Cells of the grids that it holds."""
        return 0 if self._one is None else self._one.cells

    def message(self) -> dict[str, Any]:
        """Return the message ``localization``."""
        return OFF if self._one is None else self._one.message()

    def obey(self, command: dict[str, Any], mapper: LiveMap, result: TickResult) -> None:
        """Begin to localize the robot in a plan of the present world, change the parameters, or end it.

        Raises :class:`server.stream.protocol.ProtocolError` and :class:`mapper.core.errors.ConfigError`; nothing has
        changed then.
        """
        changed, given = values({"values": {}} | command), text({"map": "plan"} | command, "map")
        if not flag(command, "value"):
            self._one = None
        elif flag(command, "keep") and self._one is not None and self._one.given == given:
            self._one.change(changed)
        else:
            simulation = mapper.simulation
            self._one = LabLocalization(
                simulation.world, simulation.sensor, simulation.mount, mapper.newest_pose, changed, given
            )
        result.slot(self.message())

    def look(self, mapper: LiveMap, result: TickResult) -> None:
        """Let the filter see the newest scan."""
        scan = mapper.newest
        if self._one is None or scan is None or mapper.hidden:
            return
        if self._one.look(scan, mapper.newest_pose):
            result.changed = True
            result.slot(self.message())

    def carried(self, pose: PoseTuple) -> None:
        """Note that the robot was carried to ``pose``, which the filter is not told."""
        if self._one is not None:
            self._one.carried(pose)

    def end(self, result: TickResult) -> None:
        """End it."""
        if self._one is not None:
            self._one = None
            result.slot(OFF)
