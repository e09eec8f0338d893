"""Provenance of a cell's value: every beam that touched it, in order, with the evidence it added.

It is recomputed from the log and the parameters on each request, so the map stores no history.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.cell_statistics import begin, shown
from mapper.mapping.integrate import scans_at_once
from mapper.mapping.joint_scans import PlannedBatch, SensorOrder, planned_parts, runs_of
from mapper.mapping.kernels.cones import contributions_of_cones
from mapper.mapping.kernels.contributions import (
    contributions_of_fields,
    contributions_of_lines,
    contributions_of_rays,
    filter_readings_near_cell,
    running_sum,
)
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.scan_batch import ScanBatch, scan_batch_of_log
from mapper.mapping.update import plan_beams
from mapper.mapping.update_plan import UpdatePlan, plan_update, update_certainties
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import ScanLog

OUTWEIGHED = 2  #: a miss in a cell that its own scan hits, if only hits count


def contributions(
    batch: ScanBatch, geometry: GridGeometry, plan: UpdatePlan, cell: tuple[int, int]
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return the readings that touch ``cell`` (row, col), and the evidence (n,) of each in log-odds.

    The readings (n, 2) int64 are scan · n_beams + beam, and 1 for a hit, 0 for a miss, or :data:`OUTWEIGHED`, in the
    order in which they are added.
    """
    if plan.draws_cones:
        return _in_cones(batch, geometry, plan, cell)
    touches = (_in_fields if plan.per_scan else _on_beams)(batch, geometry, plan, cell)
    if plan.strategy.smooth:
        return touches, _ramp_increments(batch, geometry, plan, cell, touches)
    if plan.only_hits:
        touches = _hits_first(touches, batch.numbers[touches[:, 0] // batch.ranges.shape[1]])
    update = plan.log_odds_update
    return touches, np.array([update.miss, update.hit, 0.0], dtype=np.float32)[touches[:, 1]]


def _hits_first(touches: NDArray[np.int64], scans: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return touches (n, 2) of a cell by ``scans`` (n,), marking as outweighed the misses of scans that hit the cell.

    Within each scan the misses follow the hits.
    """
    is_miss = touches[:, 1] == 0
    outweighed = is_miss & np.isin(scans, scans[~is_miss])
    kinds = np.where(outweighed, OUTWEIGHED, touches[:, 1])
    return np.column_stack([touches[:, 0], kinds])[np.lexsort((outweighed, scans))]


def _in_cones(
    batch: ScanBatch, geometry: GridGeometry, plan: UpdatePlan, cell: tuple[int, int]
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    out, increments = np.empty((batch.ranges.size, 2), np.int64), np.empty(batch.ranges.size, np.float32)
    view = (geometry.frame, plan.reading_filter, plan.cone, plan.evidence)
    n = contributions_of_cones(batch.scans_on(geometry), *view, *cell, out, increments)
    return out[:n], increments[:n]


def _in_fields(batch: ScanBatch, geometry: GridGeometry, plan: UpdatePlan, cell: tuple[int, int]) -> NDArray[np.int64]:
    out = np.empty((len(batch.ranges), 2), dtype=np.int64)
    n = contributions_of_fields(batch.scans_on(geometry), geometry.frame, plan.reading_filter, *cell, out)
    return out[:n]


def _on_beams(batch: ScanBatch, geometry: GridGeometry, plan: UpdatePlan, cell: tuple[int, int]) -> NDArray[np.int64]:
    """Return the touches (n, 2). Only beams that pass near the cell are planned."""
    scans = batch.scans_on(geometry)
    sifted, near = np.empty_like(scans.ranges), np.empty(len(scans.ranges), dtype=np.bool_)
    filter_readings_near_cell(scans, geometry.frame, plan.reading_filter, *cell, sifted, near)
    chosen = scans._replace(
        ranges=sifted[near],
        sensors=scans.sensors[near],
        headings=scans.headings[near],
        numbers=scans.numbers[near],
    )
    planned = plan_beams(chosen, geometry, plan, 1).planned
    out = np.empty((chosen.ranges.size, 2), dtype=np.int64)
    if plan.exact_rays:
        n = contributions_of_rays(planned, geometry.resolution, *cell, out)
    else:
        n = contributions_of_lines(planned, *cell, out)
    n_beams = batch.ranges.shape[1]
    numbers, beams = np.divmod(out[:n, 0], n_beams)
    out[:n, 0] = np.flatnonzero(near)[numbers] * n_beams + beams
    return out[:n]


def _ramp_increments(
    batch: ScanBatch,
    geometry: GridGeometry,
    plan: UpdatePlan,
    cell: tuple[int, int],
    touches: NDArray[np.int64],
) -> NDArray[np.float32]:
    """Return the evidence (n,), log-odds, of each of ``touches`` (n, 2) of a cell by thin beams with a smooth ramp."""
    model = plan.model
    scans, beams = np.divmod(touches[:, 0], batch.ranges.shape[1])
    z = batch.ranges[scans, beams].astype(np.float64)
    x, y, cos, sin = batch.sensors[scans].T
    column, row = geometry.to_lattice(np.stack([x, y], axis=-1)).T
    d_col, d_row = cell[1] + 0.5 - column, cell[0] + 0.5 - row
    s = np.sqrt(d_col * d_col + d_row * d_row) * geometry.resolution
    returned = (z >= batch.range_min) & (z <= batch.range_max)
    z = np.where(returned, z, 0.0)
    px, py = (z * part for part in batch.beams[beams].T)
    ends = geometry.world_to_cell(np.stack([x + cos * px - sin * py, y + sin * px + cos * py], axis=-1))
    ended = returned & (ends == np.array(cell)).all(axis=-1)
    within = model.increment(s, z)  # type: ignore[arg-type] # a ramp takes a reading for each distance as well
    thin = np.where(touches[:, 1] == 1, within, model.log_odds_miss)
    return np.where(ended, model.log_odds_hit, thin).astype(np.float32)


_Named: TypeAlias = Callable[[NDArray[np.int64]], NDArray[np.int64]]

_FIRST_READINGS = 1 << 11  # size of the first part, before the time per scan is known


@dataclass(frozen=True, slots=True)
class Provenance:
    """The touches of one cell, one entry each, in the order in which the map was built.

    ``scans`` and ``beams`` (n,) int64 identify the reading, and ``ranges`` (n,) float32 is its range in metres (beyond
    the max range: no return). ``hits`` (n,) bool marks hits, and ``outweighed`` (n,) bool marks misses that are ignored
    because their scan hits the cell. ``increments`` (n,) float32 is the evidence (for models that keep statistics: the
    change), and ``log_odds`` (n,) float32 the cell's value after it. ``before`` is the value before the first touch,
    ``prior`` the value before all logs. ``cell_statistics`` is the state from which a model with statistics continues.
    """

    scans: NDArray[np.int64]
    beams: NDArray[np.int64]
    ranges: NDArray[np.float32]
    hits: NDArray[np.bool_]
    outweighed: NDArray[np.bool_]
    increments: NDArray[np.float32]
    log_odds: NDArray[np.float32]
    before: float
    prior: float
    cell_statistics: NDArray[np.float32] | None = field(default=None, repr=False)

    @property
    def after(self) -> float:
        """The final log-odds of the cell."""
        return float(self.log_odds[-1]) if len(self.log_odds) else self.before


def provenance(
    geometry: GridGeometry,
    log: ScanLog,
    config: MappingConfig,
    cell: tuple[int, int],
    trajectory: str | None = None,
    stop: int | None = None,
    before: Provenance | None = None,
    prior: float | None = None,
    pause: Callable[[], object] = lambda: None,
) -> Provenance:
    """Return the effect of the first ``stop`` scans of ``log`` (None: all) on ``cell`` (row, col) of a map.

    For a map of several logs, each call processes one log, and ``before`` is the result for the previous one. ``prior``
    is ℓ₀ of the cell if a prior map sets it to another value than ``config``. A per-scan update that hits a cell is
    attributed to the first beam that ended in it. ``pause`` is called between parts of the log, which take a few
    hundredths of a second each. Raises :class:`ConfigError` for a cell outside the grid or for scans that the log does
    not have.
    """
    stop = log.n_scans if stop is None else stop
    row, col = (int(n) for n in cell)
    if not geometry.contains((row, col)):
        raise ConfigError(
            "provenance.cell",
            f"Cell (row {row}, column {col}) is outside the grid of {geometry.size_text} cells (width × height).",
        )
    if not 0 <= stop <= log.n_scans:
        raise ConfigError("log.scans", f"The log has no scans 0 to {stop}; it has {log.n_scans}.")
    plan = plan_update(config, log.range_min, log.range_max)
    batches = _Batches(log, config, trajectory, stop, pause)
    if before is None:
        before = _nothing(config.log_odds_prior if prior is None else prior)
    if plan.strategy.statistics != "none":
        of_statistics = _of_certainties if plan.strategy.statistics == "certainties" else _of_counts
        touches, log_odds, cell_statistics = of_statistics(batches, geometry, plan, (row, col), before)
        increments = np.diff(log_odds, prepend=np.float32(before.after))
    else:
        touches, increments = batches.joined(lambda batch, plan: contributions(batch, geometry, plan, (row, col)))
        log_odds, cell_statistics = np.empty_like(increments), None
        low, high = plan.log_odds_update.low, plan.log_odds_update.high
        running_sum(increments, np.float32(before.after), low, high, log_odds)
    scans, beams = np.divmod(touches[:, 0], max(1, log.n_beams))
    kinds = (touches[:, 1] == 1, touches[:, 1] == OUTWEIGHED)
    return Provenance(
        scans, beams, log.ranges[scans, beams], *kinds, increments, log_odds, before.after, before.prior,
        cell_statistics,
    )  # fmt: skip


def _nothing(prior: float) -> Provenance:
    """Return the provenance of an untouched cell."""
    none, values = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.float32)
    neither = np.empty(0, dtype=np.bool_)
    return Provenance(none, none, values, neither, neither, values, values, prior, prior)


@dataclass(frozen=True, slots=True)
class _Batches:
    """The first ``stop`` scans of a log, in parts; ``pause`` is called after each."""

    log: ScanLog
    config: MappingConfig
    trajectory: str | None
    stop: int
    pause: Callable[[], object]

    def joined(
        self,
        look: Callable[[ScanBatch, UpdatePlan], tuple[NDArray[np.int64], NDArray[np.float32]]],
        *,
        by_turns: bool = False,
    ) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        """Apply ``look`` to each part and return its touches, and a value for each, renumbered for the whole log.

        With ``by_turns``, ``look`` receives the scans of several sensors in time order.
        """
        touches: list[NDArray[np.int64]] = []
        values: list[NDArray[np.float32]] = []
        start, count = 0, max(1, _FIRST_READINGS // max(1, self.log.n_beams))
        while start < self.stop or not touches:  # a log without scans has one part, for the right shapes
            last = min(start + count, self.stop)
            began = time.thread_time()
            for parts in self._batches(start, last, by_turns=by_turns):
                contributions = []
                for batch, plan, named in parts:
                    part, value = look(batch, plan)
                    part[:, 0] = named(part[:, 0])
                    contributions.append((part, value))
                part, value = (np.concatenate(several) for several in zip(*contributions, strict=True))
                if len(contributions) > 1:
                    order = np.argsort(part[:, 0] // max(1, self.log.n_beams), kind="stable")
                    part, value = part[order], value[order]
                touches.append(part)
                values.append(value)
            count = scans_at_once(max(1, last - start), time.thread_time() - began)
            start = last
            self.pause()
        return np.concatenate(touches), np.concatenate(values)

    def _batches(
        self, start: int, stop: int, *, by_turns: bool
    ) -> Iterator[Sequence[tuple[ScanBatch, UpdatePlan, _Named]]]:
        """Yield the scans [start, stop) with their plan and the function that maps reading numbers of a batch to the
        log's.

        Batches yielded together belong to several sensors whose scans alternate.
        """
        log, n_beams = self.log, self.log.n_beams

        def named(part: PlannedBatch) -> tuple[ScanBatch, UpdatePlan, _Named]:
            return part.batch, part.plan, partial(part.named, n_beams=n_beams)

        if isinstance(log, JointLog):
            for parts in planned_parts(SensorOrder.of(log), self.config, self.trajectory, start, stop):
                if by_turns and len(parts) > 1:
                    for k, first, last in runs_of(parts):
                        yield [named(parts[k].rows(first, last))]
                else:
                    yield [named(part) for part in parts]
            return
        plan = plan_update(self.config, log.range_min, log.range_max)
        batch = scan_batch_of_log(log, plan, self.trajectory, start, stop)
        yield [(batch, plan, lambda readings: readings + start * n_beams)]


def _of_certainties(
    batches: _Batches, geometry: GridGeometry, plan: UpdatePlan, cell: tuple[int, int], before: Provenance
) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.float32]]:
    """Return the touches (n, 2), the log-odds (n,) after each, and the final certainties.

    The effect of an arc on a cell depends on the whole arc, so the map is built again while the cell is watched.
    """
    grid = OccupancyGrid(geometry, before.prior)
    begin(grid, plan.strategy)
    if before.cell_statistics is not None:
        grid.cell_statistics = before.cell_statistics.copy()
    box, number = np.zeros(4, dtype=np.int64), geometry.cols * cell[0] + cell[1]
    touches, certainties = batches.joined(
        lambda batch, plan: update_certainties(grid, batch.scans_on(geometry), plan, box, number)[1:], by_turns=True
    )
    assert grid.cell_statistics is not None  # noqa: S101 - begun above
    return touches, shown(plan, certainties[:, 0], certainties[:, 1], before.prior), grid.cell_statistics


def _of_counts(
    batches: _Batches, geometry: GridGeometry, plan: UpdatePlan, cell: tuple[int, int], before: Provenance
) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.float32]]:
    """Return the touches (n, 2), the log-odds (n,) after each, and the final hits and misses (2,)."""
    touches, _ = batches.joined(lambda batch, plan: contributions(batch, geometry, plan, cell))
    counted = np.zeros(2, dtype=np.float32) if before.cell_statistics is None else before.cell_statistics
    counts = counted[:, np.newaxis] + np.array([np.cumsum(touches[:, 1] == kind) for kind in (1, 0)], dtype=np.float32)
    log_odds = shown(plan, counts[0], counts[1], before.prior)
    return touches, log_odds, counts[:, -1] if len(touches) else counted
