"""Symmetric positive definite system over poses, with blocks from pairs of poses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.errors import ConfigError
from mapper.slam.kernels.block_cholesky import count_factor, factorise, solve_factorised
from mapper.slam.kernels.edges import add_pairs

MOST_MULTIPLIED = 10_000_000  #: block products between two checks for cancellation: 0.2 s


class SparseSystem:
    """The system H Δ = b over ``n`` poses with contributions of ``pairs`` (p, 2); its pattern is analysed once.

    ``fixed`` are poses that do not move (their Δ is 0). The elimination order is SuperLU's minimum degree of the
    pattern AᵀA + A, obtained from SciPy; the factorisation is :mod:`mapper.slam.kernels.block_cholesky`.
    """

    def __init__(self, n: int, pairs: Int64Array, fixed: Int64Array) -> None:
        self.n = n
        free = np.ones(n, dtype=np.bool_)
        free[fixed] = False
        number = np.full(n, -1, dtype=np.int64)
        number[free] = np.arange(np.count_nonzero(free))
        ends = number[pairs].reshape(-1, 2)
        m = int(np.count_nonzero(free))
        both = (ends >= 0).all(axis=1) & (ends[:, 0] != ends[:, 1])
        position = elimination_order(m, ends[both])
        self._row = np.full(n, -1, dtype=np.int64)
        self._row[free] = position
        self._ends = np.where(ends >= 0, position[ends] if m else ends, -1)
        low, high = self._ends[both].min(axis=1), self._ends[both].max(axis=1)
        keys, slot = np.unique(high * max(m, 1) + low, return_inverse=True)
        self._rows = keys % max(m, 1)
        self._starts = np.searchsorted(keys // max(m, 1), np.arange(m + 1)).astype(np.int64)
        self._slots = np.full(len(pairs), -1, dtype=np.int64)
        self._slots[both] = slot
        self._is_swapped = np.ascontiguousarray(self._ends[:, 0] > self._ends[:, 1])
        self._parent = np.empty(m, dtype=np.int64)
        self._factor_starts = np.empty(m + 1, dtype=np.int64)
        count_factor(self._starts, self._rows, self._parent, self._factor_starts)
        self._first, self._second = (np.ascontiguousarray(self._ends[:, k]) for k in range(2))
        filled = int(self._factor_starts[-1]) if m else 0
        self._factor_rows = np.empty(filled, dtype=np.int64)
        self._factor = np.empty((filled, 3, 3))
        self._diagonal, self._upper, self._right = np.empty((m, 3, 3)), np.empty((len(keys), 3, 3)), np.empty((m, 3))

    @property
    def filled(self) -> int:
        """Number of blocks of the factor."""
        return len(self._factor_rows)

    def solve(
        self,
        hessians: Float64Array,
        gradients: Float64Array,
        damping: float = 0.0,
        check: Callable[[], None] | None = None,
    ) -> Float64Array:
        """Return Δ (n, 3) for the blocks (p, 6, 6) and (p, 6) of the pairs, in their order.

        The diagonal is multiplied by 1 + ``damping`` and increased by ``damping`` ≥ 0 (Levenberg–Marquardt). ``check``
        is called from time to time and may raise to cancel the work. Raises :class:`ConfigError` if the system is
        singular.
        """
        for part in (self._diagonal, self._upper, self._right):
            part.fill(0.0)
        add_pairs(
            self._first, self._second, self._slots, self._is_swapped, hessians, gradients,
            self._diagonal, self._upper, self._right,
        )  # fmt: skip
        if damping > 0.0:
            for r in range(3):
                self._diagonal[:, r, r] += damping * (1.0 + self._diagonal[:, r, r])
        failed = np.empty(1, dtype=np.int64)
        row, m = 0, len(self._parent)
        ends = np.empty(m, dtype=np.int64)
        while True:
            row = factorise(
                self._starts, self._rows, self._diagonal, self._upper, self._parent, self._factor_starts,
                self._factor_rows, self._factor, failed, row, ends, MOST_MULTIPLIED,
            )  # fmt: skip
            if check is not None:
                check()
            if row >= m:
                break
        if failed[0] >= 0:
            pose = int(np.flatnonzero(self._row == failed[0])[0])
            raise ConfigError(
                "graph.singular", f"The graph leaves pose {pose} undetermined: its edges do not hold it in place."
            )
        x = self._right.copy()
        solve_factorised(self._factor_starts, self._factor_rows, self._factor, x)
        out = np.zeros((self.n, 3))
        free = self._row >= 0
        out[free] = x[self._row[free]]
        return out


def elimination_order(n: int, pairs: Int64Array) -> Int64Array:
    """Return the position (n,) of each of n unknowns in an elimination order that keeps the factor sparse.

    ``pairs`` (p, 2) are the unknowns that share a block.
    """
    if n == 0 or not len(pairs):
        return np.arange(n, dtype=np.int64)
    ones = np.full(len(pairs), -1e-6)
    pattern = sparse.csc_array(
        (np.r_[ones, ones], (np.r_[pairs[:, 0], pairs[:, 1]], np.r_[pairs[:, 1], pairs[:, 0]])), shape=(n, n)
    )
    pattern.setdiag(np.ones(n))
    options = {"SymmetricMode": True}
    factor = splu(pattern.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    return np.asarray(factor.perm_c, dtype=np.int64)
