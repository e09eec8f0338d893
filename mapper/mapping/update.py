"""Adding a batch of scans to a grid, on all cores where that is worth while."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mapper.core.parallel import cores
from mapper.grid import OccupancyGrid
from mapper.mapping import cell_statistics
from mapper.mapping.bands import draw_in_bands
from mapper.mapping.certainty_update import update_certainties
from mapper.mapping.kernels.cones import draw_cones
from mapper.mapping.kernels.types import Cells, LogOddsUpdate
from mapper.mapping.parameters import Statistics
from mapper.mapping.per_scan_update import draw_field_evidence
from mapper.mapping.scan_batch import ScanBatch
from mapper.mapping.thin_update import ONE_HIT, ONE_MISS, count_beams, draw_beam_evidence
from mapper.mapping.turns import Turns
from mapper.mapping.update_plan import UpdatePlan, check_beam_length


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


WORTH_SHARING = 1 << 12  #: readings: below this a second thread costs more time than it saves

#: Adds scans, on a number of threads; returns the number of cell updates and widens a box (row0, row1, col0, col1).
Update = Callable[[OccupancyGrid, Turns, int, NDArray[np.int64]], int]


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
