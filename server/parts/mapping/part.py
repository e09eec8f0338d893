"""The mapping parameters of a model. Commands change them, and a tick recomputes the map at most once."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict

from mapper.core.errors import MapperError, WorkCancelledError
from mapper.core.parameter import Parameter, Values
from mapper.mapping.parameters import PARAMETERS, MappingConfig
from server.sessions.hosting import ModelHost
from server.sessions.part import Part
from server.sessions.scene_controls import ParameterTable
from server.sessions.tick import TickResult
from server.stream.commands import ParametersCommand
from server.stream.hub import Client
from server.stream.message_parts import Table, rows_of
from server.stream.messages import FrameMessage, ParametersMessage


class MappingParameters(Part):
    """The parameters of the current map, and the requested ones.

    ``remake`` recomputes the whole map with other parameters; if it raises :class:`MapperError`, nothing has changed.
    ``message`` returns the ``parameters`` message. Parameters that are not in ``rows`` keep their initial values.
    """

    commands = (ParametersCommand,)
    is_on = False  # the map that it changes belongs to the source

    def __init__(
        self,
        host: ModelHost,
        config: MappingConfig,
        remake: Callable[[MappingConfig, TickResult], None],
        message: Callable[[], ParametersMessage],
        rows: tuple[Parameter, ...] = PARAMETERS,
    ) -> None:
        self.config = config  #: of the current map
        self._host, self._remake, self._message = host, remake, message
        self._rows = rows
        self._wanted = config  #: requested parameters; if they differ, :meth:`settle` recomputes the map
        self._asked_by: Client | None = None
        self._remade_ms: float | None = None

    def handle(self, command: ParametersCommand, result: TickResult) -> None:
        """Request other parameters, which :meth:`settle` applies. Raises :class:`mapper.core.errors.ConfigError`."""
        fixed = {row.name: row.initial for row in PARAMETERS if row not in self._rows}
        self._wanted, self._asked_by = self._wanted.with_values(command.values).with_values(fixed), result.client

    def adopt(self, config: MappingConfig) -> None:
        """Set the parameters of a map that was changed by other means; requested changes remain."""
        before, self.config = self.config, config
        self._wanted = self._wanted.with_values(_changed(before, config))

    def settle(self, result: TickResult) -> None:
        """Recompute the map if other parameters were requested; refuse them if that fails."""
        asked_by, self._asked_by = self._asked_by, None
        if self._wanted == self.config:
            return
        started = time.perf_counter()
        try:
            with self._host.cancellable():
                self._remake(self._wanted, result)
        except WorkCancelledError:
            result.cancelled = True  # the next tick carries out the newer command, and uses these parameters too
            return
        except MapperError as error:
            self._wanted = self.config
            result.refuse(asked_by, error)
            result.resent.append((asked_by, "parameters"))
            return
        self.config = self._wanted
        self._remade_ms = result.remade_ms = (time.perf_counter() - started) * 1000.0
        result.changed = True
        result.slot(self._message())

    def cancel(self, result: TickResult) -> None:
        """Drop requested parameters that are not applied yet, and send the applied ones to all clients."""
        if self._wanted != self.config:
            self._wanted, self._asked_by = self.config, None
            result.slot(self._message())

    def table(self, first: MappingConfig) -> Table:
        """Return the ``parameters`` of ``hello``: the table with initial values ``first``, and the values."""
        return Table(rows_of(self._rows, first), asdict(self.config))

    def controls(self) -> ParameterTable:
        """Return the table for the panel of the 3D view."""
        return ParameterTable("Mapping", self._rows, asdict(self.config), ParametersCommand, ("model",))

    def complete_frame(self, frame: FrameMessage) -> None:
        """Set the field of ``frame`` about the last recomputation of the map."""
        if self._remade_ms is not None:
            frame.remade_ms = round(self._remade_ms, 2)


def _changed(before: MappingConfig, after: MappingConfig) -> Values:
    """Return the values of ``after`` that differ from those of ``before``."""
    return {name: value for name, value in asdict(after).items() if value != getattr(before, name)}
