"""The commands about one cell of a map: its state (``inspect``) and its contributions (``why``)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import structlog

from mapper.core.errors import MapperError
from server.parts.why.explanation import CellAsked, cell_message, why_message
from server.parts.why.messages import InspectCommand, WhyCommand
from server.sessions.part import ExplainedMap, Offers, Part
from server.sessions.tick import TickResult
from server.stream.hub import Client
from server.stream.messages import ErrorMessage
from server.stream.protocol import ProtocolError

_log = structlog.get_logger(__name__)


def part_of(offers: Offers) -> CellQuestions | None:
    """Return the part, None where no cell can be asked about."""
    return None if offers.explained is None else CellQuestions(offers.explained)


class CellQuestions(Part):
    """Answers questions about cells of the maps that ``maps`` returns; the default map is the first."""

    commands = (InspectCommand, WhyCommand)
    is_on = False  # it only answers

    def __init__(self, maps: Callable[[], Sequence[ExplainedMap]]) -> None:
        self._maps = maps

    def handle(self, command: InspectCommand | WhyCommand, result: TickResult) -> None:
        """Answer a question.

        Of several "why" of one client in one tick only the newest is answered, from the map at the end of the tick.
        Raises :class:`ProtocolError`.
        """
        match command:
            case InspectCommand():
                asked = self._map_of(command)
                row, col, epoch = _cell_of(command, asked)
                result.answer(cell_message(asked.grid, row, col, epoch, asked.layer.name))
            case WhyCommand():
                client = result.client
                result.questions[client] = lambda: self._explain(client, command, result)

    def _map_of(self, command: InspectCommand | WhyCommand) -> ExplainedMap:
        for one in self._maps():
            if one.layer.name == command.layer:
                return one
        raise ProtocolError("command.layer", f"There is no map {command.layer!r:.80} to ask about.")

    def _explain(self, client: Client | None, command: WhyCommand, result: TickResult) -> None:
        try:
            asked = self._map_of(command)
            row, col, epoch = _cell_of(command, asked)
            about = CellAsked(row, col, epoch, asked.index, asked.layer.name)
            answer = why_message(asked.grid, asked.scans(), asked.config, about, command.until)
            result.answers.append((client, answer))
        except (ProtocolError, MapperError) as error:
            result.refuse(client, error)
        except Exception:  # noqa: BLE001 - a defect in one answer must not end the session
            _log.exception("a command failed", command="why")
            result.answers.append((client, ErrorMessage("internal", "The cell could not be explained.")))


def _cell_of(command: InspectCommand | WhyCommand, asked: ExplainedMap) -> tuple[int, int, int]:
    """Return the row, the column and the epoch of the cell that a command names. Raises :class:`ProtocolError`."""
    row, col, epoch = command.row, command.col, command.epoch
    now = asked.layer.epoch
    if epoch != now:
        raise ProtocolError("command.epoch", f"Epoch {epoch} is over; the map is in epoch {now}.")
    if not asked.grid.geometry.contains((row, col)):
        raise ProtocolError("command.cell", f"Cell ({row}, {col}) lies outside the map.")
    return row, col, epoch
