"""Small groups of occupied cells, found in bands of rows."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from mapper.core.array_types import Int8Array, Int64Array
from mapper.editing.areas import row_bands
from mapper.editing.operations import VALUES

_TOUCHING = np.ones((3, 3))  #: cells touch by sides or corners


def without_specks(values: Int8Array, cells: float, check: Callable[[], None]) -> Int8Array:
    """Return ``values`` (rows, cols) in which groups of at most ``cells`` occupied cells are free.

    ``check`` is called before each band of rows. The groups of a band are found alone; those that touch across the
    border of two bands are joined afterwards.
    """
    rows, cols = values.shape
    bands = [*row_bands(rows, cols)]
    groups = np.zeros(values.shape, dtype=np.int32)
    sizes = [np.zeros(1, dtype=np.int64)]  # group 0 is no group
    n_groups = 0
    for row0, row1 in bands:
        check()
        found, n_found = ndimage.label(values[row0:row1] == VALUES["occupied"], structure=_TOUCHING)
        sizes.append(np.bincount(found.ravel(), minlength=n_found + 1)[1:])
        groups[row0:row1] = np.where(found > 0, found + n_groups, 0)
        n_groups += n_found
    n_cells = np.concatenate(sizes)
    pairs = [_touching(groups[row0 - 1], groups[row0]) for _, (row0, _) in pairwise(bands)]
    if pairs:
        check()
        _add_joined(n_cells, np.concatenate(pairs))
    small = n_cells <= cells
    small[0] = False
    new = values.copy()
    for row0, row1 in bands:
        check()
        new[row0:row1][small[groups[row0:row1]]] = VALUES["free"]
    return new


def _touching(above: NDArray[np.int32], below: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the pairs (n, 2) of groups that touch across the border of two rows of groups (cols,)."""
    cols = len(above)
    pairs = [
        np.column_stack((above[max(shift, 0) : cols + min(shift, 0)], below[max(-shift, 0) : cols - max(shift, 0)]))
        for shift in (-1, 0, 1)
    ]
    every = np.concatenate(pairs)
    return every[(every > 0).all(axis=1)]


def _add_joined(n_cells: Int64Array, pairs: NDArray[np.int32]) -> None:
    """Give each group of ``pairs`` (n, 2) the cells of all groups with which it is joined; ``n_cells`` is written."""
    joined, at = np.unique(pairs, return_inverse=True)
    first, second = at.reshape(-1, 2).T
    n = len(joined)
    links = coo_array((np.ones(len(first), dtype=np.int8), (first, second)), shape=(n, n))
    _, component = connected_components(links, directed=False)
    total = np.bincount(component, weights=n_cells[joined])
    n_cells[joined] = total[component].astype(np.int64)
