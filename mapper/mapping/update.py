"""Adding a batch of scans to a grid, on all cores where that is worth while.

In the update per scan the fields of some scans are planned by scans, then drawn by bands of rows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import prod

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.core.parallel import cores, in_parallel, scratch, shares
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.grid.kernels.lattice import Frame
from mapper.mapping import cell_statistics
from mapper.mapping.certainty_update import update_certainties
from mapper.mapping.kernels.bitmask_fill import MAX_SIDE, PLANES, observe
from mapper.mapping.kernels.cones import draw_cones
from mapper.mapping.kernels.perceptual_field import Plan, draw_fields, plan_fields
from mapper.mapping.kernels.types import Cells, LogOddsUpdate, ReadingFilter, Scans
from mapper.mapping.parameters import Statistics
from mapper.mapping.scan_batch import ScanBatch
from mapper.mapping.thin_update import ONE_HIT, ONE_MISS, Draw, count_beams, draw_beam_evidence, draw_in_bands
from mapper.mapping.update_plan import Run, Turns, UpdatePlan, check_beam_length, part_of

WORTH_SHARING = 1 << 12  #: readings: below this a second thread costs more time than it saves
#: Adds scans, on a number of threads; returns the number of cell updates and widens a box (row0, row1, col0, col1).
Update = Callable[[OccupancyGrid, Turns, int, NDArray[np.int64]], int]
Span = tuple[int, int]


def draw_cone_evidence(
    grid: OccupancyGrid,
    turns: Turns,
    log_odds_update: LogOddsUpdate,
    threads: int,
    box: NDArray[np.int64],
) -> int:
    """Add all scans to ``grid``; return the number of cell updates and widen ``box`` (4,) to hold what was touched."""
    cells = Cells(grid.log_odds.reshape(-1), grid.observed.reshape(-1), grid.geometry.cols)
    marks_endpoints = any(plan.cone.mark_endpoints for _, plan in turns.sensors)
    marked = np.zeros(grid.log_odds.size if marks_endpoints else 0, dtype=np.bool_)
    pieces = turns.pieces

    def draw(row_low: int, row_high: int, box: NDArray[np.int64]) -> int:
        count = 0
        for scans, plan in pieces:
            count += draw_cones(
                cells, scans, grid.geometry.frame, plan.reading_filter, plan.cone, plan.evidence, marked,
                log_odds_update, row_low, row_high, box,
            )  # fmt: skip
        return count

    evenly = np.ones(grid.geometry.rows)
    return draw_in_bands(draw, evenly, (0, len(evenly)), threads, box)


def update_grid(grid: OccupancyGrid, batch: ScanBatch, plan: UpdatePlan) -> tuple[int, NDArray[np.int64]]:
    """Add all scans of a batch, as :func:`update_in_turns`."""
    chunks = batch.chunks_on(grid.geometry)
    return update_in_turns(grid, plan, [Turns.of_one(scans, plan) for scans in chunks])


def update_in_turns(grid: OccupancyGrid, plan: UpdatePlan, chunks: Sequence[Turns]) -> tuple[int, NDArray[np.int64]]:
    """Add all scans, one chunk after another; what falls outside the grid is clipped.

    ``plan`` is that of any sensor: those of all differ in the limits of their readings only. Return the number of cell
    updates and the box (row0, row1, col0, col1) of what was touched, half-open; it is empty where row1 ≤ row0. Raises
    :class:`mapper.core.errors.ConfigError` for cells so small that a beam crosses too many of them, and for a grid that
    holds the statistics of another kind of model.
    """
    for length in {one.beam_length for turns in chunks for _, one in turns.sensors}:
        check_beam_length(length, grid.geometry.resolution)
    threads = cores() if sum(turns.readings for turns in chunks) >= WORTH_SHARING else 1
    rows, cols = grid.geometry.shape
    box = np.array([rows, 0, cols, 0], dtype=np.int64)
    cell_statistics.begin(grid, plan.strategy)
    update = _UPDATES[plan.strategy.statistics]
    count = sum(update(grid, turns, threads, box) for turns in chunks)
    cell_statistics.show(grid, plan, box)
    return count, box


def _add_log_odds(grid: OccupancyGrid, turns: Turns, threads: int, box: NDArray[np.int64]) -> int:
    _, plan = turns.sensors[0]
    return _draw(grid, turns, plan.log_odds_update, threads, box)


def _count(grid: OccupancyGrid, turns: Turns, threads: int, box: NDArray[np.int64]) -> int:
    """Count the hits and the misses of each cell."""
    _, plan = turns.sensors[0]
    if not plan.draws_cones and not plan.per_scan:
        return count_beams(grid, turns, threads, box)
    _draw(grid.with_statistic(0), turns, ONE_HIT, threads, box)
    return _draw(grid.with_statistic(1), turns, ONE_MISS, threads, box)


def _add_certainties(
    grid: OccupancyGrid,
    turns: Turns,
    threads: int,  # noqa: ARG001 - an arc may be anywhere in the grid, so one thread adds all
    box: NDArray[np.int64],
) -> int:
    return sum(update_certainties(grid, scans, plan, box)[0] for scans, plan in turns.pieces)


_UPDATES: Mapping[Statistics, Update] = {
    "none": _add_log_odds,
    "counts": _count,
    "certainties": _add_certainties,
}


def _draw(
    grid: OccupancyGrid, turns: Turns, log_odds_update: LogOddsUpdate, threads: int, box: NDArray[np.int64]
) -> int:
    """Add all scans by ``log_odds_update``; return the number of cell updates and widen ``box`` (4,)."""
    _, plan = turns.sensors[0]
    if plan.draws_cones:
        return draw_cone_evidence(grid, turns, log_odds_update, threads, box)
    draw = draw_field_evidence if plan.per_scan else draw_beam_evidence
    return draw(grid, turns, log_odds_update, threads, box)


@dataclass(frozen=True, slots=True)
class PlannedScans:
    """Planned updates of some scans, with the scans."""

    scans: Scans
    frame: Frame
    reading_filter: ReadingFilter
    plan: Plan
    toggles: NDArray[np.uint32]


@dataclass(frozen=True, slots=True)
class PlannedFields:
    """Planned updates of scans, part by part, with their places in the grid.

    ``rows`` and ``words`` (of 32 columns) [first, stop) hold all that they see in the grid; ``work`` (grid rows,) says
    what each row costs.
    """

    parts: list[PlannedScans]
    views: NDArray[np.int64]
    work: NDArray[np.float64]
    rows: Span
    words: Span


def draw_field_evidence(
    grid: OccupancyGrid,
    turns: Turns,
    log_odds_update: LogOddsUpdate,
    threads: int,
    box: NDArray[np.int64],
) -> int:
    """Add all scans to ``grid``; return the number of cell updates and widen ``box`` (4,) to hold what was touched.

    Raises :class:`ConfigError` for a grid of MAX_SIDE rows or columns.
    """
    fields = _in_turns([plan_of_fields(scans, grid.geometry, plan, threads) for scans, plan in turns.sensors], turns)
    if fields.rows[0] >= fields.rows[1] or fields.words[0] >= fields.words[1]:
        return 0
    return draw_in_bands(drawer_of_fields(fields, grid, log_odds_update), fields.work, fields.rows, threads, box)


def _in_turns(planned: Sequence[PlannedFields], turns: Turns) -> PlannedFields:
    """Return what each sensor's scans will draw as what all will draw in their order."""
    if len(planned) == 1:
        return planned[0]
    parts = [part for run in turns.runs for part in _of_run(planned[run[0]].parts, run)]
    views = np.concatenate([one.views for one in planned])
    work = np.sum([one.work for one in planned], axis=0)
    return PlannedFields(parts, views, work, *_seen(views))


def _of_run(parts: Sequence[PlannedScans], run: Run) -> Iterator[PlannedScans]:
    """Yield the scans of a run out of a sensor's, which follow one another in ``parts``."""
    _, first, stop = run
    for part in parts:
        n = len(part.scans.ranges)
        a, b = max(first, 0), min(stop, n)
        if a < b:
            starts, sure, views = part.plan
            own = (starts[a:b], sure[a:b], views[a:b])
            yield PlannedScans(part_of(part.scans, a, b), part.frame, part.reading_filter, own, part.toggles)
        first, stop = first - n, stop - n


def plan_of_fields(scans: Scans, geometry: GridGeometry, plan: UpdatePlan, threads: int) -> PlannedFields:
    """Plan the fields of some scans, in the order of the log.

    Raises :class:`ConfigError` for a grid of MAX_SIDE rows or columns.
    """
    if max(geometry.shape) >= MAX_SIDE:
        raise ConfigError(
            "grid.size",
            f"The per-scan update takes grids of less than {MAX_SIDE} rows and columns; choose larger cells.",
        )
    frame, reading_filter, n = geometry.frame, plan.reading_filter, len(scans.ranges)
    starts, sure = np.empty((n, PLANES + 1), dtype=np.int64), np.empty(n, dtype=np.bool_)
    views = np.empty((n, 4), dtype=np.int64)
    work = np.zeros((threads, geometry.rows + 1))

    def planned(a: int, b: int, own_work: NDArray[np.float64]) -> PlannedScans:
        part, own = part_of(scans, a, b), (starts[a:b], sure[a:b], views[a:b])
        toggles = plan_fields(part, frame, reading_filter, geometry.cols, own, own_work)
        return PlannedScans(part, frame, reading_filter, own, toggles)

    parts = in_parallel(
        [partial(planned, a, b, own) for (a, b), own in zip(shares(n, threads), work, strict=True)]
    )  # fmt: skip
    return PlannedFields(parts, views, np.cumsum(work.sum(axis=0))[:-1], *_seen(views))


def drawer_of_fields(planned: PlannedFields, grid: OccupancyGrid, log_odds_update: LogOddsUpdate) -> Draw:
    """Return the function that draws the fields into rows within ``planned.rows``."""
    (row, row_stop), (word, word_stop) = planned.rows, planned.words
    seen = np.zeros((row_stop - row, word_stop - word), dtype=np.int64)
    seen_place = (row, word, word_stop - word, 0)
    views = planned.views

    def draw(row_low: int, row_high: int, box: NDArray[np.int64]) -> int:
        rows = int((views[:, 1].clip(row_low, row_high) - views[:, 0].clip(row_low, row_high)).max())
        shape = (PLANES, rows, int((views[:, 3] - views[:, 2]).max()) + 1)
        count = 0
        with scratch(prod(shape) + rows) as store:
            used, planes = store[:rows], store[rows : rows + prod(shape)].reshape(shape)
            for part in planned.parts:
                count += draw_fields(
                    grid.log_odds, seen, seen_place, part.scans, part.frame, part.reading_filter, part.plan,
                    part.toggles, planes, used, log_odds_update, row_low, row_high,
                )  # fmt: skip
        observe(grid.observed, seen, seen_place, row_low, row_high, box)
        return count

    return draw


def _seen(views: NDArray[np.int64]) -> tuple[Span, Span]:
    """Return the rows and the words [first, stop) that hold all views of some scans."""
    views = views[views[:, 0] < views[:, 1]]
    if len(views) == 0:
        return (0, 0), (0, 0)
    low, high = views[:, ::2].min(axis=0), views[:, 1::2].max(axis=0)
    return (int(low[0]), int(high[0])), (int(low[1]), int(high[1]))
