"""A scan's field as a sheet of bits: noted where rows enter and leave it, then added to the grid many cells at a time.

What a scan frees is a star-shaped region, and a row of the grid enters and leaves it a few times. Each such place is a
*toggle*, one bit in a plane of bits with 32 cells to a word. The running exclusive or along a row, five shifts for a
word, then tells for each cell whether it lies inside: the scanline fill of a polygon by its edges' parity (Foley, van
Dam, Feiner & Hughes, Computer Graphics, section 3.5). Each word is added to 32 cells at once.
"""

from __future__ import annotations

import numpy as np

from mapper.kernels.compiled import jit
from mapper.kernels.types import BoolArray, Float32Array, Int64Array, Rule

#: A sheet is ``planes`` (3, rows, words) int64, 32 cells to a word, and ``used`` (rows,) int64, which has a bit for
#: each 1 << shift words in which some plane is not 0. FREE has the toggles of the region in which a scan's cells are
#: free, OUTER those of the region that reaches to the far end of the hit windows, HITS a bit for each cell hit in any
#: case.
PLANES = 3
FREE, OUTER, HITS = range(PLANES)
_FREE, _OUTER, _HITS = np.uint64(FREE), np.uint64(OUTER), np.uint64(HITS)
#: Where a sheet lies: the row of the grid at which it begins, the word (of 32 columns) likewise, and the shift.
Place = tuple[int, int, int]

WORD_BITS = 5
WORD = 1 << WORD_BITS  #: cells
_ALL = (1 << WORD) - 1
USED_BITS = 62  #: of a row's word in ``used``, which stay clear of its sign


@jit
def _toggle(planes: Int64Array, used: Int64Array, place: Place, plane: int, row: int, column: int) -> None:
    """Flip the bit of a column, which must lie in the sheet, as its row.

    Without a branch, for numba counts references to arrays at each one, and with unsigned indices, of which it does not
    ask whether they count from the end: either costs more than all the rest.
    """
    c = column - WORD * place[1]
    w, r = min(max(c >> WORD_BITS, 0), planes.shape[2] - 1), np.uint64(row - place[0])
    planes[np.uint64(plane), r, np.uint64(w)] ^= 1 << (c & (WORD - 1))
    used[r] |= 1 << (w >> place[2])


@jit
def _mark(planes: Int64Array, used: Int64Array, place: Place, row: int, column: int) -> None:
    """Note that a cell, which must lie in the sheet, is hit."""
    c = column - WORD * place[1]
    w, r = min(max(c >> WORD_BITS, 0), planes.shape[2] - 1), np.uint64(row - place[0])
    planes[_HITS, r, np.uint64(w)] |= 1 << (c & (WORD - 1))
    used[r] |= 1 << (w >> place[2])


@jit
def _wipe(planes: Int64Array, used: Int64Array) -> None:
    """Forget all that was noted."""
    planes[:, : len(used)] = 0
    used[:] = 0


@jit
def _ones(word: int) -> int:
    """Return how many bits of a word are set, in the form that compilers know as one instruction."""
    count = 0
    while word:
        word &= word - 1
        count += 1
    return count


@jit
def _span(bits: int) -> tuple[int, int]:
    """Return the places [first, stop) of the lowest and the highest bit of a word that is not 0."""
    first = _ones((bits & -bits) - 1)
    for shift in (1, 2, 4, 8, 16, 32):
        bits |= bits >> shift
    return first, _ones(bits)


@jit
def _filled(toggles: int) -> int:
    """Return for each bit of a word whether an odd number of toggles lies at it and before it."""
    toggles ^= toggles << 1
    toggles ^= toggles << 2
    toggles ^= toggles << 4
    toggles ^= toggles << 8
    toggles ^= toggles << 16
    return toggles & _ALL


@jit
def _add(cells: Float32Array, start: int, inside: int, hits: int, rule: Rule) -> None:
    """Add evidence to those of 32 cells whose bit is set, in the form that compilers turn into vector instructions."""
    miss, hit, low, high = rule
    for c in range(WORD):
        at = np.uint64(start + c)
        before = cells[at]
        increment = hit if (hits >> c) & 1 else miss
        value = min(max(before + increment, low), high)
        cells[at] = value if (inside >> c) & 1 else before


@jit
def _settle(
    cells: Float32Array, cols: int, seen: Int64Array, seen_place: Place, planes: Int64Array, used: Int64Array,
    place: Place, windows: bool, rule: Rule,
) -> int:  # fmt: skip
    """Add what a sheet says to the grid and wipe it; return the number of updates.

    ``cells`` (rows · cols,) is the grid, row after row, at least 32 columns wide; the sheet's rows lie in it. In
    ``seen`` (rows, words) int64, which lies at ``seen_place``, the bits of the cells touched are set. With ``windows``
    the plane OUTER counts.
    """
    count = 0
    words = (cols + WORD - 1) >> WORD_BITS
    for row in range(len(used)):
        r = np.uint64(row)
        if used[r] == 0:
            continue
        first, stop = _span(used[r])
        first, stop = first << place[2], min(stop << place[2], planes.shape[2])
        used[r] = 0
        free_before, outer_before = 0, 0  # all ones where the row is inside at the end of the last word
        for i in range(first, min(-place[1], stop)):  # left of the grid
            free_before ^= _ALL * (_ones(planes[FREE, r, i]) & 1)
            outer_before ^= _ALL * (_ones(planes[OUTER, r, i]) & 1)
            planes[:, r, i] = 0
        start = (place[0] + row) * cols
        noted_row = np.uint64(place[0] + row - seen_place[0])
        for i in range(max(first, -place[1]), min(stop, words - place[1])):
            w = np.uint64(i)
            free, hits = planes[_FREE, r, w], planes[_HITS, r, w]
            planes[_FREE, r, w], planes[_HITS, r, w] = 0, 0
            free = _filled(free) ^ free_before
            free_before = -(free >> (WORD - 1)) & _ALL
            if windows:
                outer = _filled(planes[_OUTER, r, w]) ^ outer_before
                planes[_OUTER, r, w] = 0
                outer_before = -(outer >> (WORD - 1)) & _ALL
                hits |= free ^ outer
            inside = free | hits
            if inside == 0:
                continue
            # The last word of a row may reach beyond it: then the row's last 32 cells are taken.
            base = WORD * (place[1] + i)
            beyond = max(base + WORD - cols, 0)
            inside = (inside << beyond) & _ALL
            _add(cells, start + base - beyond, inside, hits << beyond, rule)
            seen[noted_row, np.uint64(place[1] + i - seen_place[1])] |= inside >> beyond
            count += _ones(inside)
        for i in range(max(first, words - place[1]), stop):  # right of the grid
            planes[:, r, i] = 0
    return count


@jit
def _settle_narrow(
    cells: Float32Array, cols: int, seen: Int64Array, seen_place: Place, planes: Int64Array, used: Int64Array,
    place: Place, windows: bool, rule: Rule,
) -> int:  # fmt: skip
    """As :func:`_settle`, cell by cell, for a grid of any width."""
    miss, hit, low, high = rule
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
    """Note the cells of the rows [row_low, row_high) that have a bit in ``seen`` (rows, words) int64 as observed.

    ``observed`` (rows, cols) bool is the grid's. ``box`` (4,) int64 (row0, row1, col0, col1), half-open, is widened to
    hold them.
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
