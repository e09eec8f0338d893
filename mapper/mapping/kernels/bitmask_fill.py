"""A scan's field as a bitmask: toggles where rows enter and leave it, then addition to many cells at a time.

The free space of a scan is a star-shaped region, and a row of the grid enters and leaves it a few times. Each crossing
is a *toggle*, one bit in a bit plane with 32 cells per word. The running exclusive or along a row, five shifts per
word, then determines for each cell whether it is inside: the scanline fill of a polygon by edge parity (Foley, van Dam,
Feiner & Hughes, Computer Graphics, section 3.5). Each word is added to 32 cells at once.
"""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import BoolArray, Float32Array, Int64Array, UInt32Array
from mapper.core.jit import jit
from mapper.mapping.kernels.types import LogOddsUpdate

#: A bitmask is ``planes`` (3, rows, words + 1) int64, 32 cells per word, and ``used`` (rows,) int64, with one bit for
#: each 1 << shift words in which some plane is not 0. FREE has the toggles of the region in which a scan's cells are
#: free, OUTER those of the region up to the far end of the hit windows, HITS a bit for each cell that always counts as
#: hit. The extra word holds toggles at the far side of the bitmask, after which there are no cells.
PLANES = 3
FREE, OUTER, HITS = range(PLANES)
#: Position of a bitmask: its first row in the grid, its first word (of 32 columns), its number of words, and the shift.
Place = tuple[int, int, int, int]

WORD_BITS = 5
WORD = 1 << WORD_BITS  #: cells
_ALL = (1 << WORD) - 1
USED_BITS = 62  #: bits of a row's word in ``used``; the sign bit is not used
_COLUMN_BITS = 16
MAX_SIDE = (1 << _COLUMN_BITS) - WORD  #: rows or columns of a grid that a toggle can represent


@jit
def _packed(row: int, column: int) -> np.uint32:
    """Pack a row and a column, relative to a corner of the scan's view, into one word of 32 bits."""
    return np.uint32((row << _COLUMN_BITS) | column)


@jit
def _note(
    plane: Int64Array, used: Int64Array, shift: int, sticks: bool, toggles: UInt32Array, first_row: int
) -> None:  # fmt: skip
    """Flip the bits of the cells ``toggles`` (n,), or set them if a bit ``sticks``.

    ``first_row`` is the bitmask's first row in the numbering of the toggles. Rows outside the bitmask belong to another
    thread and are skipped.
    """
    sticky = -1 if sticks else 0
    rows = len(used)
    for j in range(len(toggles)):
        toggle = np.int64(toggles[j])
        row, column = (toggle >> _COLUMN_BITS) - first_row, toggle & ((1 << _COLUMN_BITS) - 1)
        if 0 <= row < rows:
            r, w = np.uint64(row), np.uint64(column >> WORD_BITS)
            before = plane[r, w]
            plane[r, w] = before ^ ((1 << (column & (WORD - 1))) & ~(before & sticky))
            used[r] |= 1 << ((column >> WORD_BITS) >> shift)


@jit
def _toggle(planes: Int64Array, used: Int64Array, place: Place, plane: int, row: int, column: int) -> None:
    """Flip the bit of a column. The row must be in the bitmask; columns beyond its sides are moved to the side.

    There are no branches, because numba counts array references at each one, and indices are unsigned, because numba
    checks signed ones for negative values. Either would cost more than everything else.
    """
    c = min(max(column - WORD * place[1], 0), WORD * place[2])
    w, r = c >> WORD_BITS, np.uint64(row - place[0])
    planes[np.uint64(plane), r, np.uint64(w)] ^= 1 << (c & (WORD - 1))
    used[r] |= 1 << (w >> place[3])


@jit
def _mark(planes: Int64Array, used: Int64Array, place: Place, row: int, column: int) -> None:
    """Mark a cell as hit. The row must be in the bitmask; columns beyond its sides are dropped."""
    c = column - WORD * place[1]
    if 0 <= c < WORD * place[2]:
        planes[HITS, row - place[0], c >> WORD_BITS] |= 1 << (c & (WORD - 1))
        used[row - place[0]] |= 1 << ((c >> WORD_BITS) >> place[3])


@jit
def _ones(word: int) -> int:
    """Return the number of set bits, in a form that compilers recognise as one instruction."""
    count = 0
    while word:
        word &= word - 1
        count += 1
    return count


@jit
def _span(bits: int) -> tuple[int, int]:
    """Return the positions [first, stop) of the lowest and the highest set bit of a non-zero word."""
    first = _ones((bits & -bits) - 1)
    for shift in (1, 2, 4, 8, 16, 32):
        bits |= bits >> shift
    return first, _ones(bits)


@jit
def _filled(toggles: int) -> int:
    """Return for each bit of a word whether the number of toggles up to and including it is odd."""
    toggles ^= toggles << 1
    toggles ^= toggles << 2
    toggles ^= toggles << 4
    toggles ^= toggles << 8
    toggles ^= toggles << 16
    return toggles & _ALL


@jit
def _add(cells: Float32Array, start: int, inside: int, hits: int, log_odds_update: LogOddsUpdate) -> None:
    """Add evidence to those of 32 cells whose bit is set, in a form that compilers vectorise."""
    miss, hit, low, high = log_odds_update
    for c in range(WORD):
        at = np.uint64(start + c)
        before = cells[at]
        increment = hit if (hits >> c) & 1 else miss
        value = min(max(before + increment, low), high)
        cells[at] = value if (inside >> c) & 1 else before


@jit
def _settle(
    cells: Float32Array, cols: int, seen: Int64Array, seen_place: Place, planes: Int64Array, used: Int64Array,
    place: Place, windows: bool, log_odds_update: LogOddsUpdate,
) -> int:  # fmt: skip
    """Add a bitmask to the grid and clear it; return the number of updates.

    ``cells`` (rows · cols,) is the grid, row by row, at least 32 columns wide; the bitmask is within it. In ``seen``
    (rows, words) int64, which starts at ``seen_place``, the bits of touched cells are set. The plane OUTER is used only
    with ``windows``.
    """
    free_plane, outer_plane, hit_plane = planes[FREE].reshape(-1), planes[OUTER].reshape(-1), planes[HITS].reshape(-1)
    noted, noted_length = seen.reshape(-1), seen.shape[1]
    noted_start = (place[0] - seen_place[0]) * noted_length + place[1] - seen_place[1]
    length = planes.shape[2]
    corner = place[0] * cols + WORD * place[1]
    last = cols - WORD * (place[1] + 1)  # column, relative to the bitmask, of the row's last 32 cells
    count = 0
    for row in range(len(used)):
        r = np.uint64(row)
        if used[r] == 0:
            continue
        first, stop = _span(used[r])
        first, stop = first << place[3], min(stop << place[3], place[2])
        used[r] = 0
        free_before, outer_before = 0, 0  # all ones if the row is inside the region at the end of the previous word
        for word in range(first, stop):
            w = np.uint64(row * length + word)
            free, hits = free_plane[w], hit_plane[w]
            free_plane[w], hit_plane[w] = 0, 0
            free = _filled(free) ^ free_before
            free_before = -(free >> (WORD - 1)) & _ALL
            if windows:
                outer = _filled(outer_plane[w]) ^ outer_before
                outer_plane[w] = 0
                outer_before = -(outer >> (WORD - 1)) & _ALL
                hits |= free ^ outer
            # The last word of a row may extend beyond it; then the row's last 32 cells are used.
            beyond = max(WORD * word - last, 0)
            inside = ((free | hits) << beyond) & _ALL
            _add(cells, corner + row * cols + WORD * word - beyond, inside, hits << beyond, log_odds_update)
            noted[np.uint64(noted_start + row * noted_length + word)] |= inside >> beyond
            count += _ones(inside)
        spare = np.uint64(row * length + place[2])
        free_plane[spare], outer_plane[spare] = 0, 0
    return count


@jit
def _settle_narrow(
    cells: Float32Array, cols: int, seen: Int64Array, seen_place: Place, planes: Int64Array, used: Int64Array,
    place: Place, windows: bool, log_odds_update: LogOddsUpdate,
) -> int:  # fmt: skip
    """Like :func:`_settle`, cell by cell, for a grid of any width."""
    miss, hit, low, high = log_odds_update
    count = 0
    for r in range(len(used)):
        free, outer = 0, 0
        for i in range(WORD * planes.shape[2] if used[r] != 0 else 0):
            w, b, col = i >> WORD_BITS, i & (WORD - 1), WORD * place[1] + i
            free ^= (planes[FREE, r, w] >> b) & 1
            outer = outer ^ ((planes[OUTER, r, w] >> b) & 1) if windows else free
            hits = (free ^ outer) | ((planes[HITS, r, w] >> b) & 1)
            if (free | hits) != 0 and 0 <= col < cols:
                cell = (place[0] + r) * cols + col
                cells[cell] = min(max(cells[cell] + (hit if hits else miss), low), high)
                seen[place[0] + r - seen_place[0], (col >> WORD_BITS) - seen_place[1]] |= 1 << b
                count += 1
        planes[:, r, :] = 0
        used[r] = 0
    return count


@jit
def observe(observed: BoolArray, seen: Int64Array, place: Place, row_low: int, row_high: int, box: Int64Array) -> None:
    """Mark the cells of the rows [row_low, row_high) that have a bit in ``seen`` (rows, words) int64 as observed.

    ``observed`` (rows, cols) bool is the grid's. ``box`` (4,) int64 (row0, row1, col0, col1), half-open, is extended to
    these cells.
    """
    for r in range(row_low, row_high):
        noted = seen[r - place[0]]
        for w in range(len(noted)):
            bits = noted[w]
            if bits == 0:
                continue
            base = WORD * (place[1] + w)
            cells = observed[r, base : base + WORD]
            for c in range(len(cells)):
                cells[c] |= ((bits >> c) & 1) != 0
            first, stop = _span(bits)
            box[0], box[1] = min(box[0], r), max(box[1], r + 1)
            box[2], box[3] = min(box[2], base + first), max(box[3], base + stop)
