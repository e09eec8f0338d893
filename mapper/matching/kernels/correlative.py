"""Correlative matching: the pose in a window with the greatest total score of a scan's points.

Exhaustive (Olson 2009) and by branch and bound (Hess et al. 2016), with identical results. Numba twins of
:func:`mapper.matching.textbook.scores_in_window`.
"""

from __future__ import annotations

from math import cos, sin
from typing import NamedTuple

import numpy as np

from mapper.core.array_types import Float64Array, Int32Array, Int64Array, UInt8Array
from mapper.core.jit import jit
from mapper.grid.kernels.lattice import Frame, cell_of, to_lattice
from mapper.matching.kernels.types import NO_POINT, ScanArrays

_to_lattice = jit(to_lattice)
_cell_of = jit(cell_of)


class Window(NamedTuple):
    """Poses around a guess: whole cells to each side along the grid's axes, and whole steps of rotation."""

    cells: int  #: to each side
    turns: int  #: to each side
    turn: float  #: rad, one step


@jit
def _write_cells(
    scans: ScanArrays, i: int, pose: Float64Array, window: Window, frame: Frame, stride: int, cells: Int32Array
) -> int:
    """Write the cells (2 · turns + 1, n, 2), row and column, of the points at each rotation; return n."""
    n = 0
    for a in range(2 * window.turns + 1):
        theta = pose[2] + (a - window.turns) * window.turn
        c, s = cos(theta), sin(theta)
        n = 0
        for k in range(0, scans.points.shape[1], stride):
            if scans.kind[i, k] == NO_POINT:
                continue
            p_x, p_y = np.float64(scans.points[i, k, 0]), np.float64(scans.points[i, k, 1])
            u, v = _to_lattice(pose[0] + c * p_x - s * p_y, pose[1] + s * p_x + c * p_y, frame)
            # Far outside the grid all cells are equivalent.
            cells[a, n, 0] = int(min(max(_cell_of(v), -1e8), 1e8))
            cells[a, n, 1] = int(min(max(_cell_of(u), -1e8), 1e8))
            n += 1
    return n


@jit
def _add_block(scores: UInt8Array, cells: Int32Array, n: int, row: int, col: int, step: int, total: Int32Array) -> None:
    """Write the sums (h, w) of the scores at n cells moved by (row + y · step, col + x · step) for all y and x.

    A score (rows, cols) stands for the square of ``step`` cells starting at its cell. For a square that begins less
    than ``step`` cells before the grid, the first row or column is read, which bounds the square's score.
    """
    rows, cols = scores.shape
    h, w = total.shape
    # Flat arrays and unsigned indices: a slice per row would count references, and an index that may be negative
    # prevents the compiler from adding several cells at once.
    flat, out = scores.reshape(-1), total.reshape(-1)
    out[:] = 0
    for k in range(n):
        top, left = np.int64(cells[k, 0]) + row, np.int64(cells[k, 1]) + col
        if top >= rows or left >= cols or top + h * step <= 0 or left + w * step <= 0:
            continue
        first = 0 if left >= 0 else -left // step
        last = min(w, (cols - left + step - 1) // step)
        for y in range(h):
            at = top + y * step
            if -step < at < rows:
                if step == 1:
                    source, target = np.uintp(at * cols + left + first), np.uintp(y * w + first)
                    for x in range(np.uintp(last - first)):
                        out[target + x] += flat[source + x]
                else:
                    line = max(at, 0) * cols
                    for x in range(first, last):
                        out[y * w + x] += flat[line + max(left + x * step, 0)]


@jit
def score_window(
    scores: UInt8Array,
    frame: Frame,
    scans: ScanArrays,
    i: int,
    pose: Float64Array,
    window: Window,
    stride: int,
    volume: Int32Array,
) -> int:
    """Write the score of each pose of a window (2 · turns + 1, 2 · cells + 1, 2 · cells + 1): turn, row, column.

    ``scores`` (rows, cols) on ``frame``; every ``stride``-th point of scan i counts, and those outside the grid score
    0. ``pose`` (3,) is the centre of the window. Returns the number of points.
    """
    cells = np.empty((2 * window.turns + 1, scans.points.shape[1] // stride + 1, 2), dtype=np.int32)
    n = _write_cells(scans, i, pose, window, frame, stride, cells)
    for a in range(2 * window.turns + 1):
        _add_block(scores, cells[a], n, -window.cells, -window.cells, 1, volume[a])
    return n


@jit
def best_in_window(volume: Int32Array, best: Int64Array) -> None:
    """Write the greatest score of a window, and its turn, row and column from the centre (4,); the first of equals."""
    turns, cells = volume.shape[0] // 2, volume.shape[1] // 2
    best[0], best[1], best[2], best[3] = -1, 0, 0, 0
    for a in range(volume.shape[0]):
        for y in range(volume.shape[1]):
            for x in range(volume.shape[2]):
                if volume[a, y, x] > best[0]:
                    best[0], best[1], best[2], best[3] = volume[a, y, x], a - turns, y - cells, x - cells


@jit
def _bound_blocks(
    levels: UInt8Array,
    frame: Frame,
    scans: ScanArrays,
    i: int,
    pose: Float64Array,
    window: Window,
    stride: int,
    least: int,
) -> tuple[Int32Array, int, Int32Array, Int64Array]:
    """Return the points' cells and their number, the bounds of the top-level blocks, and the sorted candidate blocks.

    Candidates are the blocks with a bound of at least ``least``, the greatest bound first.
    """
    side = 1 << (levels.shape[0] - 1)
    blocks = (2 * window.cells + 1 + side - 1) // side
    n_turns = 2 * window.turns + 1
    cells = np.empty((n_turns, scans.points.shape[1] // stride + 1, 2), dtype=np.int32)
    n = _write_cells(scans, i, pose, window, frame, stride, cells)
    bounds = np.empty((n_turns, blocks, blocks), dtype=np.int32)
    for a in range(n_turns):
        _add_block(levels[levels.shape[0] - 1], cells[a], n, -window.cells, -window.cells, side, bounds[a])
    flat = bounds.reshape(-1)
    candidates = np.flatnonzero(flat >= least)
    return cells, n, flat, candidates[np.argsort(-flat[candidates].astype(np.int64), kind="mergesort")]


@jit
def _excluded(maxima: Int64Array, count: int, apart: Window, turn: int, y: int, x: int, side: int) -> bool:
    """Return whether all poses of a block are near one of the first ``count`` poses of ``maxima`` (k, 4)."""
    for k in range(count):
        if (
            abs(turn - maxima[k, 1]) <= apart.turns
            and y >= maxima[k, 2] - apart.cells
            and y + side - 1 <= maxima[k, 2] + apart.cells
            and x >= maxima[k, 3] - apart.cells
            and x + side - 1 <= maxima[k, 3] + apart.cells
        ):
            return True
    return False


@jit
def _descend(
    levels: UInt8Array,
    cells: Int32Array,
    n: int,
    flat: Int32Array,
    order: Int64Array,
    window: Window,
    least: int,
    apart: Window,
    best: Int64Array,
    k: int,
) -> None:
    """Write row k of ``best`` (., 4): the best pose that is not near those of the rows before."""
    top = levels.shape[0] - 1
    side = 1 << top
    size = 2 * window.cells + 1
    blocks = (size + side - 1) // side
    score, best_turn, best_y, best_x, is_any = least, window.turns + 1, 0, 0, False
    # A stack of blocks: bound, level, and row and column of the block's first pose relative to the window's first pose.
    stack = np.empty((4 * top + 4, 4), dtype=np.int64)
    four = np.empty((2, 2), dtype=np.int32)
    for at in order:
        if flat[at] < score:
            break
        a = at // (blocks * blocks)
        turn = a - window.turns
        stack[0, 0], stack[0, 1] = flat[at], top
        stack[0, 2], stack[0, 3] = (at // blocks) % blocks * side, at % blocks * side
        height = 1
        while height > 0:
            height -= 1
            bound, level, row, col = stack[height, 0], stack[height, 1], stack[height, 2], stack[height, 3]
            y, x = row - window.cells, col - window.cells
            if bound < score or _excluded(best, k, apart, turn, y, x, 1 << level):
                continue
            if level == 0:
                # Of equal scores the first in window order is chosen.
                before = turn < best_turn or (turn == best_turn and (y < best_y or (y == best_y and x < best_x)))
                if bound > score or not is_any or before:
                    score, best_turn, best_y, best_x, is_any = bound, turn, y, x, True
                continue
            half = 1 << (level - 1)
            _add_block(levels[level - 1], cells[a], n, y, x, half, four)
            # The best of the four is pushed last, to be processed first.
            begin = height
            for q in range(4):
                row_q, col_q = row + (q >> 1) * half, col + (q & 1) * half
                part = four[q >> 1, q & 1]
                if row_q >= size or col_q >= size or part < score:
                    continue
                place = height
                while place > begin and stack[place - 1, 0] > part:
                    stack[place] = stack[place - 1]
                    place -= 1
                stack[place, 0], stack[place, 1], stack[place, 2], stack[place, 3] = part, level - 1, row_q, col_q
                height += 1
    if is_any:
        best[k, 0], best[k, 1], best[k, 2], best[k, 3] = score, best_turn, best_y, best_x
    else:
        best[k, 0], best[k, 1], best[k, 2], best[k, 3] = -1, 0, 0, 0


@jit
def best_modes(
    levels: UInt8Array,
    frame: Frame,
    scans: ScanArrays,
    i: int,
    pose: Float64Array,
    window: Window,
    stride: int,
    least: int,
    share: float,
    apart: Window,
    best: Int64Array,
) -> int:
    """Write the best pose of the window, then the best pose apart from all before, and so on (k, 4).

    Poses are scored as in :func:`branch_and_bound`. Two poses are apart if they differ by more than ``apart.cells`` in
    row or column, or by more than ``apart.turns``. Poses after the first need at least its score times ``share``; rows
    without a pose are −1, 0, 0, 0. Returns the number of points.
    """
    least = max(least, 1)
    cells, n, flat, order = _bound_blocks(levels, frame, scans, i, pose, window, stride, least)
    best[:, 0] = -1
    best[:, 1:] = 0
    for k in range(best.shape[0]):
        _descend(levels, cells, n, flat, order, window, least, apart, best, k)
        if best[k, 0] < 0:
            break
        if k == 0:
            least = max(least, int(share * best[0, 0]))
    return n


@jit
def branch_and_bound(
    levels: UInt8Array,
    frame: Frame,
    scans: ScanArrays,
    i: int,
    pose: Float64Array,
    window: Window,
    stride: int,
    least: int,
    best: Int64Array,
) -> int:
    """Write the result of :func:`best_in_window` for the whole window, without scoring each pose.

    ``levels`` (n, rows, cols) are the grids of :func:`mapper.matching.kernels.score_field.write_pyramid`. The score of
    a block of 2^l poses per side is bounded by the sum over level l. Top-level blocks are processed in the order of
    their bounds, and divided into four if the bound is not below the best score so far. Poses that score less than
    ``least`` (at least 1) do not count; if there is no other, ``best`` (4,) is −1, 0, 0, 0. Returns the number of
    points.
    """
    return best_modes(
        levels, frame, scans, i, pose, window, stride, least, 1.0, Window(-1, -1, 0.0), best.reshape(1, 4)
    )
