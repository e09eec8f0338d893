"""The per-scan update on all cores: the fields of some scans are planned by scans, then drawn by bands of rows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import prod
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.kernels.field import Plan, draw_fields, plan_fields
from mapper.kernels.sheet import PLANES, WORD, observe
from mapper.kernels.types import Frame, Rule, Sight
from mapper.parameters import MappingConfig
from mapper.threads import in_parallel, scratch, shares

if TYPE_CHECKING:
    from mapper.sweep import Sweep

Span = tuple[int, int]


@dataclass(frozen=True, slots=True)
class PlannedFields:
    """What some scans will draw: the scans as the kernel takes them, and where in the grid.

    ``rows`` and ``words`` (of 32 columns) [first, stop) hold all that they see in the grid; ``work`` (grid rows,) says
    what each row costs.
    """

    scans: tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
    frame: Frame
    sight: Sight
    plan: Plan
    work: NDArray[np.float64]
    rows: Span
    words: Span


def plan_of_fields(
    sweep: Sweep, part: slice, geometry: GridGeometry, config: MappingConfig, threads: int
) -> PlannedFields:
    """Plan some scans of a sweep for the per-scan update."""
    ranges, sensors, headings = sweep.ranges[part], sweep.sensors[part], sweep.headings(geometry)[part]
    sight = sweep.sight(config)
    regions = 2 if sight[2] > 0.0 or sight[3] > 0.0 else 1  # with a hit window also the one that reaches to its end
    shape = (len(ranges), regions, ranges.shape[1])
    radii, corners = np.empty(shape), np.empty((*shape, 2), dtype=np.int32)
    sides, ends = np.empty(ranges.shape, dtype=np.int8), np.empty((*ranges.shape, 2), dtype=np.int32)
    sure, views = np.empty(len(ranges), dtype=np.bool_), np.empty((len(ranges), 4), dtype=np.int64)
    work = np.zeros((threads, geometry.rows + 1))
    tasks = []
    for (a, b), own_work in zip(shares(len(ranges), threads), work, strict=True):
        own = (radii[a:b], corners[a:b], sides[a:b], ends[a:b], sure[a:b], views[a:b])
        scans = (ranges[a:b], sensors[a:b], sweep.beams, sweep.fields, headings[a:b])
        tasks.append(partial(plan_fields, *scans, geometry.frame, sight, geometry.cols, own, own_work))
    in_parallel(tasks)
    return PlannedFields(
        (ranges, sensors, sweep.fields, headings), geometry.frame, sight, (radii, corners, sides, ends, sure, views),
        np.cumsum(work.sum(axis=0))[:-1], *_seen(views, geometry),
    )  # fmt: skip


def drawer_of_fields(
    planned: PlannedFields, grid: OccupancyGrid, rule: Rule
) -> Callable[[int, int, NDArray[np.int64]], int]:
    """Return what draws them into rows [row_low, row_high), which lie in ``planned.rows``, and widens a box."""
    (row, row_stop), (word, word_stop) = planned.rows, planned.words
    seen, seen_place = np.zeros((row_stop - row, word_stop - word), dtype=np.int64), (row, word, 0)
    views = planned.plan[-1]

    def draw(row_low: int, row_high: int, box: NDArray[np.int64]) -> int:
        rows = int((views[:, 1].clip(row_low, row_high) - views[:, 0].clip(row_low, row_high)).max())
        shape = (PLANES, rows, int((views[:, 3] - views[:, 2]).max()))
        with scratch(prod(shape) + rows) as store:
            used, planes = store[:rows], store[rows : rows + prod(shape)].reshape(shape)
            count = draw_fields(
                grid.log_odds, seen, seen_place, *planned.scans, planned.frame, planned.sight, planned.plan, planes,
                used, rule, row_low, row_high,
            )  # fmt: skip
        observe(grid.observed, seen, seen_place, row_low, row_high, box)
        return int(count)

    return draw


def _seen(views: NDArray[np.int64], geometry: GridGeometry) -> tuple[Span, Span]:
    """Return the rows and the words [first, stop) of the grid that hold all views of some scans."""
    views = views[views[:, 0] < views[:, 1]]
    if len(views) == 0:
        return (0, 0), (0, 0)
    low, high = views[:, ::2].min(axis=0), views[:, 1::2].max(axis=0)
    words = -(-geometry.cols // WORD)
    return (max(int(low[0]), 0), min(int(high[0]), geometry.rows)), (max(int(low[1]), 0), min(int(high[1]), words))
