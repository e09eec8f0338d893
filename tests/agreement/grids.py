"""Functions of whole grids (pictures, merged maps, states, bits), by the mapper and by the textbook."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

from mapper.grid import FREE_THRESHOLD, OCCUPIED_THRESHOLD, log_odds
from mapper.grid.kernels.quantise import quantise, quantise_cells, sort_by_tile
from mapper.grid.merge import merged
from mapper.grid.metrics import entropy
from tests.agreement.inputs import ListedCells, PictureCase, StatesCase, TwoMaps

TILE = 8
BOUNDS = (float(log_odds(FREE_THRESHOLD)), float(log_odds(OCCUPIED_THRESHOLD)))


def tiles_of(picture: np.ndarray) -> tuple[int, int]:
    rows, cols = picture.shape
    return -(-rows // TILE), -(-cols // TILE)


def picture_by_kernel(case: PictureCase) -> tuple[Any, ...]:
    picture = np.full(case.log_odds.shape, -128, dtype=np.int8)
    changed = np.zeros(tiles_of(picture), dtype=np.bool_)
    cells = np.zeros(case.room, dtype=np.uint32)
    count = quantise(
        case.log_odds, case.observed, case.low, case.high, *BOUNDS, *case.box, TILE, picture, changed, cells, 0
    )
    return picture, changed, count, cells if count <= case.room else None


def picture_of_cells_by_kernel(case: PictureCase) -> tuple[Any, ...]:
    """The cells of the box one by one, the last ones first and each twice; their list is sorted."""
    picture = np.full(case.log_odds.shape, -128, dtype=np.int8)
    changed = np.zeros(tiles_of(picture), dtype=np.bool_)
    cells = np.zeros(case.room, dtype=np.uint32)
    row0, row1, col0, col1 = (max(n, 0) for n in case.box)
    numbers = np.arange(picture.size, dtype=np.uint32).reshape(picture.shape)[row0:row1, col0:col1]
    count = quantise_cells(
        case.log_odds, case.observed, case.low, case.high, *BOUNDS, np.tile(numbers.ravel()[::-1], 2), TILE, picture,
        changed, cells, 0,
    )  # fmt: skip
    cells[:count].sort()
    cells[count:] = 0
    return picture, changed, count, cells if count <= case.room else None


def picture_by_textbook(case: PictureCase) -> tuple[Any, ...]:
    def state(log_odds: np.ndarray) -> np.ndarray:
        return (log_odds > BOUNDS[1]).astype(int) - (log_odds < BOUNDS[0])

    # The nearest of the values that stand for the same state, where there is one.
    steps = np.arange(-127, 128)
    stands_for = case.low + (steps + 127) / 254.0 * (case.high - case.low)
    log_odds = case.log_odds.astype(float)[..., None]
    away = np.abs(np.clip(log_odds, case.low, case.high) - stands_for)
    away = away + 1e3 * (state(log_odds) != state(stands_for))
    quantised = np.where(case.observed, steps[np.argmin(away, axis=-1)], -128)
    row0, row1, col0, col1 = (max(n, 0) for n in case.box)
    picture = np.full(case.log_odds.shape, -128, dtype=np.int8)
    picture[row0:row1, col0:col1] = quantised[row0:row1, col0:col1]
    changed = np.zeros(tiles_of(picture), dtype=np.bool_)
    cells = [row << 16 | col for row, col in np.argwhere(picture != -128).tolist()]
    for cell in cells:
        changed[(cell >> 16) // TILE, (cell & 0xFFFF) // TILE] = True
    listed = np.array(cells + [0] * (case.room - len(cells)), dtype=np.uint32)
    return picture, changed, len(cells), listed if len(cells) <= case.room else None


def sorted_by_kernel(case: ListedCells) -> tuple[Any, ...]:
    n = len(case.cells)
    tiles, places = np.zeros((n, 3), dtype=np.int16), np.zeros(n, dtype=np.uint16)
    values = np.zeros(n, dtype=np.int8)
    count = sort_by_tile(case.picture, case.cells, TILE, tiles, places, values)
    return tiles[:count], places, values


def sorted_by_textbook(case: ListedCells) -> tuple[Any, ...]:
    """By Python's stable sort."""
    cells = [divmod(int(cell), 1 << 16) for cell in case.cells]
    cells.sort(key=lambda cell: (cell[0] // TILE, cell[1] // TILE))
    groups = itertools.groupby(cells, key=lambda cell: (cell[1] // TILE, cell[0] // TILE))
    tiles = np.array([(*tile, len(list(group))) for tile, group in groups], dtype=np.int16).reshape(-1, 3)
    places = np.array([row % TILE * TILE + col % TILE for row, col in cells], dtype=np.uint16)
    return tiles, places, np.array([case.picture[cell] for cell in cells], dtype=np.int8)


def merged_by_core(case: TwoMaps) -> tuple[Any, ...]:
    whole = merged(case.a, case.b)
    known = np.zeros(whole.geometry.shape, np.float32) if whole.prior_map is None else whole.prior_map
    return whole.log_odds, whole.observed, known, whole.geometry.shape


def merged_by_textbook(case: TwoMaps) -> tuple[Any, ...]:
    """Cell by cell: the odds of both, divided by those of the prior."""
    evidence: dict[tuple[int, int], float] = {}
    prior: dict[tuple[int, int], float] = {}
    observed = set()
    for grid, (row, col) in ((case.a, (0, 0)), (case.b, case.offset)):
        for r, c in np.ndindex(grid.geometry.shape):
            cell = (row + r, col + c)
            known = np.nan if grid.prior_map is None else float(grid.prior_map[r, c])
            prior[cell] = 0.0 if grid.prior_map is None else known
            started = grid.log_odds_prior if np.isnan(known) else known
            evidence[cell] = evidence.get(cell, started) + float(grid.log_odds[r, c]) - started
            if grid.observed[r, c]:
                observed.add(cell)
    rows, cols = zip(*evidence, strict=True)
    top, left = min(rows), min(cols)
    shape = (max(rows) - top + 1, max(cols) - left + 1)
    nowhere = 0.0 if case.a.prior_map is None else np.nan
    values, before = np.full(shape, case.a.log_odds_prior), np.full(shape, nowhere)
    seen = np.zeros(shape, dtype=np.bool_)
    for (r, c), value in evidence.items():
        at = (r - top, c - left)
        values[at], before[at], seen[at] = value, prior[r, c], (r, c) in observed
    return values.astype(np.float32), seen, before.astype(np.float32), shape


def states_by_core(case: StatesCase) -> tuple[Any, ...]:
    return case.grid.classify(case.occupied, case.free), entropy(case.grid.log_odds).astype(np.float32)


def states_by_textbook(case: StatesCase) -> tuple[Any, ...]:
    """By probabilities, as the definitions have it."""

    def bits(log_odds: float) -> float:
        odds = math.exp(-abs(log_odds))
        p, q = 1 / (1 + odds), odds / (1 + odds)
        return -p * math.log2(p) - (q * math.log2(q) if q > 0 else 0)

    shape = case.grid.geometry.shape
    state, left = np.full(shape, -1, dtype=np.int8), np.empty(shape, dtype=np.float32)
    for cell in np.ndindex(shape):
        left[cell] = bits(float(case.grid.log_odds[cell]))
        if case.grid.observed[cell]:
            p = 1 / (1 + math.exp(-float(case.grid.log_odds[cell])))
            p = min(p, math.nextafter(1.0, 0.0))  # it is below 1 also where it is rounded to 1
            state[cell] = 100 if p > case.occupied else 0 if p < case.free else -1
    return state, left
