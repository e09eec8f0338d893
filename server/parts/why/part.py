"""The commands about one cell of a map: its state (``inspect``) and its contributions (``why``)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import structlog
from msgspec import UNSET
from numpy.typing import NDArray

from mapper.core.errors import MapperError
from mapper.grid import FREE_THRESHOLD, OCCUPIED_THRESHOLD, OccupancyGrid, probability
from mapper.mapping.joint_scans import sensor_poses_of
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.provenance import Provenance, provenance
from mapper.mapping.update_plan import plan_update
from mapper.sensors.joint_log import JointLog
from server.parts.why.messages import InspectCommand, WhyCommand
from server.sessions.part import ExplainedMap, MappedScans, Offers, Part
from server.sessions.tick import TickResult
from server.stream.hub import Client
from server.stream.message_parts import CellState, Contribution
from server.stream.messages import CellMessage, ErrorMessage, WhyMessage
from server.stream.protocol import ProtocolError
from server.work.scheduler import checkpoint

_log = structlog.get_logger(__name__)


def part_of(offers: Offers) -> CellQuestions | None:
    """Return the part, None if no cell can be explained."""
    return None if offers.explained is None else CellQuestions(offers.explained)


class CellQuestions(Part):
    """Answers to questions about cells of the maps that ``maps`` returns; the default map is the first."""

    commands = (InspectCommand, WhyCommand)
    is_on = False  # it only answers

    def __init__(self, maps: Callable[[], Sequence[ExplainedMap]]) -> None:
        self._maps = maps

    def handle(self, command: InspectCommand | WhyCommand, result: TickResult) -> None:
        """Answer a question.

        Of several "why" of one client in a tick only the last is answered, from the map at the end of the tick. Raises
        :class:`ProtocolError`.
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
        for map_ in self._maps():
            if map_.layer.name == command.layer:
                return map_
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


MAX_CONTRIBUTIONS = 300  #: maximum number described in detail in one message
STRETCHES = 300  #: number of sections of the curve, each with its minimum and maximum


@dataclass(frozen=True, slots=True)
class CellAsked:
    """The queried cell, in the map of ``index`` scans that a layer shows."""

    row: int
    col: int
    epoch: int  #: of the layer's geometry
    index: int
    layer: str


def cell_message(grid: OccupancyGrid, row: int, col: int, epoch: int, layer: str) -> CellMessage:
    """Return a ``cell`` message about the map of ``layer``."""
    x, y = grid.geometry.cell_to_world((row, col))
    value, observed = float(grid.log_odds[row, col]), bool(grid.observed[row, col])
    p_occ = float(probability(value))
    state: CellState = "unknown"
    if observed and p_occ > OCCUPIED_THRESHOLD:
        state = "occupied"
    elif observed and p_occ < FREE_THRESHOLD:
        state = "free"
    return CellMessage(
        row=row,
        col=col,
        epoch=epoch,
        x=float(x),
        y=float(y),
        observed=observed,
        log_odds=value,
        p_occ=p_occ,
        state=state,
        layer=layer,
    )


def why_message(
    grid: OccupancyGrid,
    sources: Sequence[MappedScans],
    config: MappingConfig,
    about: CellAsked,
    until: int | None = None,
) -> WhyMessage:
    """Return a ``why`` message about a cell.

    ``until`` is the last contribution to describe in detail, None for the newest. Raises :class:`ProtocolError` if it
    is below 1.
    """
    if until is not None and until < 1:
        raise ProtocolError("command.until", f"Contributions count from 1, not {until}.")
    row, col = about.row, about.col
    parts: list[Provenance] = []
    part: Provenance | None = None
    for source in sources:
        part = provenance(
            grid.geometry, source.log, config, (row, col), source.trajectory, source.stop, part, pause=checkpoint
        )
        parts.append(part)
    counts = [len(part.scans) for part in parts]
    total = sum(counts)
    stop = total if until is None else min(until, total)
    low, high = (limit if np.isfinite(limit) else None for limit in map(float, config.clamp_limits))
    first_scans = np.cumsum([0, *(source.stop for source in sources)])
    contributions: list[Contribution] = []
    first_scan = None
    n = 0
    for source, part, first in zip(sources, parts, first_scans[:-1].tolist(), strict=True):
        if first_scan is None and len(part.scans):
            first_scan = first + int(part.scans[0])
        inside = slice(max(0, stop - MAX_CONTRIBUTIONS - n), max(0, stop - n))
        contributions += _contributions(source, part, config, inside, n, first)
        n += len(part.scans)
    return WhyMessage(
        row=row,
        col=col,
        epoch=about.epoch,
        index=about.index,
        log_odds=float(grid.log_odds[row, col]),
        prior=float(config.log_odds_prior),
        log_odds_min=low,
        log_odds_max=high,
        per_scan=config.update == "per_scan",
        total=total,
        hits=sum(int(np.count_nonzero(part.hits)) for part in parts),
        outweighed=sum(int(np.count_nonzero(part.outweighed)) for part in parts),
        first_scan=first_scan,
        curve=thinned(np.concatenate([np.empty(0, np.float32), *(part.log_odds for part in parts)])),
        contributions=contributions,
        layer=about.layer,
    )


def _contributions(
    source: MappedScans, part: Provenance, config: MappingConfig, inside: slice, n: int, first_scan: int
) -> list[Contribution]:
    """Return the contributions ``inside`` one log. Earlier logs have ``n`` contributions and ``first_scan`` scans."""
    plan = plan_update(config, source.log.range_min, source.log.range_max)
    scans, beams = part.scans[inside], part.beams[inside]
    poses, angles = sensor_poses_of(source.log, config, source.trajectory, scans, beams)
    log = source.log
    sensors = [log.parts[part].topic for part in log.part_of_scan[scans]] if isinstance(log, JointLog) else None
    ranges = part.ranges[inside].astype(np.float64)
    returned = (ranges >= plan.reading_filter.range_min) & (ranges <= plan.reading_filter.range_max)
    columns = zip(
        scans.tolist(),
        np.round(source.stamps_s[scans], 3).tolist(),
        beams.tolist(),
        np.round(poses, 4).tolist(),
        np.round(angles, 5).tolist(),
        np.round(np.where(returned, ranges, 0.0), 3).tolist(),
        returned.tolist(),
        part.hits[inside].tolist(),
        part.outweighed[inside].tolist(),
        part.increments[inside].tolist(),
        part.log_odds[inside].tolist(),
        strict=True,
    )
    return [
        Contribution(
            n=n + inside.start + i + 1,
            scan=first_scan + scan,
            stamp=stamp,
            beam=beam,
            pose=pose,
            bearing=bearing,
            range=reading if is_reading else None,
            hit=hit,
            increment=round(increment, 6),
            log_odds=round(log_odds, 6),
            sensor=UNSET if sensors is None else sensors[i],
            outweighed=outweighed or UNSET,
        )
        for i, (
            scan,
            stamp,
            beam,
            pose,
            bearing,
            reading,
            is_reading,
            hit,
            outweighed,
            increment,
            log_odds,
        ) in enumerate(columns)
    ]


def thinned(log_odds: NDArray[np.float32]) -> list[tuple[int, float]]:
    """Return (n, log-odds) of at most 2 · :data:`STRETCHES` contributions, n from 1, including the last one.

    The minimum and the maximum of each section are kept, so that no peak is lost.
    """
    if len(log_odds) <= 2 * STRETCHES:
        rows = np.arange(len(log_odds))
    else:
        edges = np.linspace(0, len(log_odds) - 1, STRETCHES, dtype=np.int64)
        pairs = zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)
        ends = [(a + int(log_odds[a:b].argmin()), a + int(log_odds[a:b].argmax())) for a, b in pairs]
        rows = np.unique([*(i for pair in ends for i in pair), len(log_odds) - 1])
    return [(i + 1, round(value, 4)) for i, value in zip(rows.tolist(), log_odds[rows].tolist(), strict=True)]
