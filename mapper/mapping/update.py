"""Integration of a batch of scans into a grid in two passes, on all cores if worthwhile.

The lines of beams (update per beam) or the fields of scans (update per scan) are planned by scans, then drawn by bands
of rows. Each cell is updated by one thread, in the order of the log, so the result does not depend on the number of
threads, not even in its last bit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.core.parallel import bands, cores, in_parallel, scratch, shares
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.grid.kernels.lattice import Frame
from mapper.mapping import cell_statistics
from mapper.mapping.kernels.amanatides_woo import RAY_FIELDS, draw_rays, plan_rays
from mapper.mapping.kernels.bitmask_fill import MAX_SIDE, PLANES, observe
from mapper.mapping.kernels.bresenham import LINE_FIELDS, draw_lines, plan_lines
from mapper.mapping.kernels.cones import draw_cones
from mapper.mapping.kernels.negative_zero import decode_observed, encode_unobserved
from mapper.mapping.kernels.perceptual_field import Plan, draw_fields, plan_fields
from mapper.mapping.kernels.smooth_ramp import draw_ramps
from mapper.mapping.kernels.types import Cells, LogOddsUpdate, ReadingFilter, Scans
from mapper.mapping.parameters import Statistics
from mapper.mapping.scan_batch import ScanBatch, scan_ends
from mapper.mapping.update_plan import Run, Turns, UpdatePlan, check_beam_length, part_of, update_certainties

WORTH_SHARING = 1 << 12  #: readings: below this a second thread costs more time than it saves
#: Adds scans on a number of threads; returns the number of cell updates and extends a box (row0, row1, col0, col1).
Update = Callable[[OccupancyGrid, Turns, int, NDArray[np.int64]], int]
Span = tuple[int, int]
_ENCODE_ABOVE_UPDATES_PER_CELL = 2.0  # updates per cell of the box: below this it is cheaper to mark each one
#: One map counts the hits and one the misses: each increment adds 1 to one of them and 0 to the other.
ONE_MISS, ONE_HIT = (
    LogOddsUpdate(np.float32(miss), np.float32(1.0 - miss), np.float32(-np.inf), np.float32(np.inf))
    for miss in (1.0, 0.0)
)
#: Draws the rows [row_low, row_high), extends a box (row0, row1, col0, col1); returns the number of cell updates.
Draw = Callable[[int, int, NDArray[np.int64]], int]
NO_ENDS = np.empty(0, dtype=np.int64)  #: used when hits and misses count alike


def draw_cone_evidence(
    grid: OccupancyGrid,
    turns: Turns,
    log_odds_update: LogOddsUpdate,
    threads: int,
    box: NDArray[np.int64],
) -> int:
    """Add all scans to ``grid``. Return the number of cell updates and extend ``box`` (4,) to the touched cells."""
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
    """Add all scans of a batch like :func:`update_in_turns`."""
    chunks = batch.chunks_on(grid.geometry)
    return update_in_turns(grid, plan, [Turns.of_one(scans, plan) for scans in chunks])


def update_in_turns(grid: OccupancyGrid, plan: UpdatePlan, chunks: Sequence[Turns]) -> tuple[int, NDArray[np.int64]]:
    """Add all scans, chunk by chunk. Cells outside the grid are clipped.

    ``plan`` is that of any sensor, because the plans differ only in the limits of the readings. Return the number of
    cell updates and the touched box (row0, row1, col0, col1), half-open; it is empty if row1 ≤ row0. Raises
    :class:`mapper.core.errors.ConfigError` for cells so small that a beam crosses too many of them, and for a grid that
    holds the statistics of another kind of model.
    """
    for length in {sensor.beam_length for turns in chunks for _, sensor in turns.sensors}:
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
    """Add all scans by ``log_odds_update``. Return the number of cell updates and extend ``box`` (4,)."""
    _, plan = turns.sensors[0]
    if plan.draws_cones:
        return draw_cone_evidence(grid, turns, log_odds_update, threads, box)
    draw = draw_field_evidence if plan.per_scan else draw_beam_evidence
    return draw(grid, turns, log_odds_update, threads, box)


@dataclass(frozen=True, slots=True)
class PlannedBeams:
    """Planned updates of beams.

    ``planned`` holds the lines (9, n) int32 or the rays (n, 8) float64, ``work`` (rows,) the number of cells in each
    row of the grid, ``box`` (4,) int64 (row0, row1, col0, col1), half-open, the reached cells of the grid.
    """

    planned: NDArray[Any]
    work: NDArray[np.float64]
    box: NDArray[np.int64]


def plan_beams(scans: Scans, geometry: GridGeometry, plan: UpdatePlan, threads: int) -> PlannedBeams:
    """Plan the beams of some scans, in the order of the log."""
    readings, n_beams = scans.ranges.size, scans.ranges.shape[1]
    work = np.zeros((threads, geometry.rows + 1))
    boxes = np.tile(np.array([geometry.rows, 0, geometry.cols, 0]), (threads, 1))
    kernel: Callable[..., None] = plan_rays if plan.exact_rays else plan_lines
    planned: NDArray[Any] = (
        np.empty((readings, RAY_FIELDS)) if plan.exact_rays else np.empty((LINE_FIELDS, readings), dtype=np.int32)
    )
    view = (geometry.frame, plan.reading_filter)
    parts = zip(shares(len(scans.ranges), threads), work, boxes, strict=True)
    in_parallel(
        [
            partial(kernel, part_of(scans, a, b), *view, a * n_beams, planned, own, own_box)
            for (a, b), own, own_box in parts
        ]
    )
    boxes += [-1, 1, -1, 1]  # rounding may move an endpoint out of the line through it
    return PlannedBeams(planned, np.cumsum(work.sum(axis=0))[:-1], _joined(boxes, geometry))


def draw_beam_evidence(
    grid: OccupancyGrid,
    turns: Turns,
    log_odds_update: LogOddsUpdate,
    threads: int,
    box: NDArray[np.int64],
) -> int:
    """Add all scans to ``grid``. Return the number of cell updates and extend ``box`` (4,) to the touched cells."""
    count = 0
    for scans, plan in turns.pieces:
        beams = plan_beams(scans, grid.geometry, plan, threads)
        count += _draw_in_bands(grid, beams, _drawer(grid, beams, scans, plan, log_odds_update), threads, box)
    return count


def count_beams(grid: OccupancyGrid, turns: Turns, threads: int, box: NDArray[np.int64]) -> int:
    """Count the hits and the misses of each cell like :func:`draw_beam_evidence` with :data:`ONE_HIT` and
    :data:`ONE_MISS`.

    The beams are planned once, and hits are counted without tracing the beams.
    """
    hits, misses = grid.with_statistic(0), grid.with_statistic(1)
    count = 0
    for scans, plan in turns.pieces:
        beams = plan_beams(scans, grid.geometry, plan, threads)
        if plan.exact_rays or plan.strategy.smooth:
            _draw_in_bands(hits, beams, _drawer(hits, beams, scans, plan, ONE_HIT), threads, box)
        else:
            draw_in_bands(_hit_drawer(hits, beams), beams.work, (0, len(beams.work)), threads, box)
        count += _draw_in_bands(misses, beams, _drawer(misses, beams, scans, plan, ONE_MISS), threads, box)
    return count


def _drawer(
    grid: OccupancyGrid, beams: PlannedBeams, scans: Scans, plan: UpdatePlan, log_odds_update: LogOddsUpdate
) -> Callable[..., int]:
    """Return a function of (row_low, row_high, box, mark) that adds planned beams to rows of ``grid``."""
    cells, frame = _cells(grid), grid.geometry.frame
    smooth, evidence = plan.strategy.smooth, plan.evidence
    ends = scan_ends(scans.numbers) * scans.ranges.shape[1] if plan.only_hits else NO_ENDS
    if plan.exact_rays:
        return partial(draw_rays, cells, beams.planned, frame.resolution, smooth, evidence, log_odds_update, ends)
    if smooth:
        return partial(draw_ramps, cells, beams.planned, scans, frame, plan.reading_filter, evidence, log_odds_update)
    return partial(draw_lines, cells, beams.planned, log_odds_update, False, ends)


def _hit_drawer(grid: OccupancyGrid, beams: PlannedBeams) -> Draw:
    """Return a function that counts the hits of planned lines. Hits are few, so each cell is marked individually."""
    cells = _cells(grid)

    def draw(row_low: int, row_high: int, box: NDArray[np.int64]) -> int:
        return int(draw_lines(cells, beams.planned, ONE_HIT, True, NO_ENDS, row_low, row_high, box, True))

    return draw


def _cells(grid: OccupancyGrid) -> Cells:
    return Cells(grid.log_odds.reshape(-1), grid.observed.reshape(-1), grid.geometry.cols)


def _draw_in_bands(
    grid: OccupancyGrid, beams: PlannedBeams, draw: Callable[..., int], threads: int, box: NDArray[np.int64]
) -> int:
    band = partial(_draw_with_observed, grid, beams, draw)
    return draw_in_bands(band, beams.work, (0, len(beams.work)), threads, box)


def _joined(boxes: NDArray[np.int64], geometry: GridGeometry) -> NDArray[np.int64]:
    """Return the union (4,) of boxes (n, 4), clipped to the grid."""
    (row, col), (row_stop, col_stop) = boxes[:, ::2].min(axis=0), boxes[:, 1::2].max(axis=0)
    return np.array([max(row, 0), min(row_stop, geometry.rows), max(col, 0), min(col_stop, geometry.cols)])


def _draw_with_observed(
    grid: OccupancyGrid,
    beams: PlannedBeams,
    draw: Callable[..., int],
    row_low: int,
    row_high: int,
    box: NDArray[np.int64],
) -> int:
    """Draw a band and mark the observed cells by the method that is cheaper for this number of updates."""
    touched = beams.box.copy()
    touched[:2] = touched[:2].clip(row_low, row_high)
    cells = int((touched[1] - touched[0]) * (touched[3] - touched[2]))
    if beams.work[row_low:row_high].sum() < _ENCODE_ABOVE_UPDATES_PER_CELL * cells or not encode_unobserved(
        grid.log_odds, grid.observed, touched
    ):
        return draw(row_low, row_high, box, True)
    count = draw(row_low, row_high, box, False)
    decode_observed(grid.log_odds, grid.observed, touched)
    return count


def draw_in_bands(
    draw: Draw, work: NDArray[np.float64], rows: tuple[int, int], threads: int, box: NDArray[np.int64]
) -> int:
    """Draw the rows [first, stop) of ``rows``, one band for each thread. Return the number of cell updates.

    ``work`` (grid rows,) is the cost of each row, in any unit. ``box`` (4,) int64 (row0, row1, col0, col1), half-open,
    is extended to the touched cells.
    """
    first, stop = rows
    parts = [(first + low, first + high, box.copy()) for low, high in bands(work[first:stop], threads)]
    counts = in_parallel([partial(draw, *part) for part in parts])
    for _, _, own in parts:
        box[::2] = np.minimum(box[::2], own[::2])
        box[1::2] = np.maximum(box[1::2], own[1::2])
    return sum(int(count) for count in counts)


@dataclass(frozen=True, slots=True)
class PlannedScans:
    """Planned updates of some scans, and the scans."""

    scans: Scans
    frame: Frame
    reading_filter: ReadingFilter
    plan: Plan
    toggles: NDArray[np.uint32]


@dataclass(frozen=True, slots=True)
class PlannedFields:
    """Planned updates of scans, part by part, with their positions in the grid.

    ``rows`` and ``words`` (of 32 columns) [first, stop) bound the observed part of the grid; ``work`` (grid rows,) is
    the cost of each row.
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
    """Add all scans to ``grid``. Return the number of cell updates and extend ``box`` (4,) to the touched cells.

    Raises :class:`ConfigError` for a grid of MAX_SIDE rows or columns.
    """
    fields = _in_turns([plan_of_fields(scans, grid.geometry, plan, threads) for scans, plan in turns.sensors], turns)
    if fields.rows[0] >= fields.rows[1] or fields.words[0] >= fields.words[1]:
        return 0
    return draw_in_bands(drawer_of_fields(fields, grid, log_odds_update), fields.work, fields.rows, threads, box)


def _in_turns(planned: Sequence[PlannedFields], turns: Turns) -> PlannedFields:
    """Merge the plans of the sensors' scans into the order in which all scans are drawn."""
    if len(planned) == 1:
        return planned[0]
    parts = [part for run in turns.runs for part in _of_run(planned[run[0]].parts, run)]
    views = np.concatenate([plan.views for plan in planned])
    work = np.sum([plan.work for plan in planned], axis=0)
    return PlannedFields(parts, views, work, *_seen(views))


def _of_run(parts: Sequence[PlannedScans], run: Run) -> Iterator[PlannedScans]:
    """Yield the scans of a run from a sensor's consecutive ``parts``."""
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
    """Return a function that draws the fields into rows within ``planned.rows``."""
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
    """Return the rows and the words [first, stop) that contain all views of some scans."""
    views = views[views[:, 0] < views[:, 1]]
    if len(views) == 0:
        return (0, 0), (0, 0)
    low, high = views[:, ::2].min(axis=0), views[:, 1::2].max(axis=0)
    return (int(low[0]), int(high[0])), (int(low[1]), int(high[1]))
