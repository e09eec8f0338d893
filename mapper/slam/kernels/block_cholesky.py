"""Sparse Cholesky factorisation of a symmetric matrix of 3 × 3 blocks, and the solution of its system.

Up-looking, row by row along the elimination tree. Source: Davis 2006, Direct Methods for Sparse Linear Systems, chapter
4 (``cs_etree``, ``cs_ereach``, ``cs_chol``), with one block per pose in place of each number.
"""

from __future__ import annotations

import math

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.jit import jit


@jit
def count_factor(starts: Int64Array, rows: Int64Array, parent: Int64Array, factor_starts: Int64Array) -> None:
    """Write the elimination tree and the start of each column of the factor.

    The strict upper triangle of the matrix of n × n blocks is given by columns: column k has blocks in
    ``rows[starts[k]:starts[k + 1]]``. ``parent`` (n,) receives the tree, −1 at a root; ``factor_starts`` (n + 1,) the
    first block of each column of L, whose diagonal block comes first.
    """
    n = len(parent)
    ancestor = np.empty(n, dtype=np.int64)
    for k in range(n):
        parent[k] = -1
        ancestor[k] = -1
        for p in range(starts[k], starts[k + 1]):
            i = rows[p]
            while i != -1 and i < k:
                following = ancestor[i]
                ancestor[i] = k
                if following == -1:
                    parent[i] = k
                i = following
    mark = np.full(n, -1, dtype=np.int64)
    counts = np.ones(n, dtype=np.int64)
    for k in range(n):
        mark[k] = k
        for p in range(starts[k], starts[k + 1]):
            i = rows[p]
            while mark[i] != k:
                mark[i] = k
                counts[i] += 1
                i = parent[i]
    factor_starts[0] = 0
    for k in range(n):
        factor_starts[k + 1] = factor_starts[k] + counts[k]


@jit
def factorise(
    starts: Int64Array,
    rows: Int64Array,
    diagonal: Float64Array,
    upper: Float64Array,
    parent: Int64Array,
    factor_starts: Int64Array,
    factor_rows: Int64Array,
    factor: Float64Array,
    failed: Int64Array,
    begin: int,
    end: Int64Array,
    most: int,
) -> int:
    """Write L of A = L Lᵀ by columns: block rows ``factor_rows`` (f,) and blocks ``factor`` (f, 3, 3).

    ``diagonal`` (n, 3, 3) and ``upper`` (len(rows), 3, 3) are the blocks of A; ``parent`` and ``factor_starts`` are
    those of :func:`count_factor`. ``failed[0]`` is −1, or the block row in which A is not positive definite: the
    factor must not be used then.

    Rows from ``begin`` on are written until ``most`` blocks have been multiplied. Returns the row at which to continue,
    n after the last one. ``end`` (n,), the current end of each column, is kept between calls.
    """
    n = len(parent)
    failed[0] = -1
    multiplied = 0
    mark = np.full(n, -1, dtype=np.int64)
    pattern = np.empty(n, dtype=np.int64)
    path = np.empty(n, dtype=np.int64)
    work = np.zeros((n, 9))
    if begin == 0:
        for k in range(n):
            end[k] = factor_starts[k] + 1
    for k in range(begin, n):
        if multiplied >= most:
            return k
        # The columns in which row k of L has blocks, each after those that it depends on.
        top = n
        mark[k] = k
        for p in range(starts[k], starts[k + 1]):
            i = rows[p]
            for r in range(3):
                for c in range(3):
                    work[i, 3 * r + c] = upper[p, c, r]
            length = 0
            while mark[i] != k:
                path[length] = i
                mark[i] = k
                length += 1
                i = parent[i]
            while length > 0:
                length -= 1
                top -= 1
                pattern[top] = path[length]
        d00, d10, d11 = diagonal[k, 0, 0], diagonal[k, 1, 0], diagonal[k, 1, 1]
        d20, d21, d22 = diagonal[k, 2, 0], diagonal[k, 2, 1], diagonal[k, 2, 2]
        for t in range(top, n):
            i = pattern[t]
            first = factor_starts[i]
            l00, l10, l11 = factor[first, 0, 0], factor[first, 1, 0], factor[first, 1, 1]
            l20, l21, l22 = factor[first, 2, 0], factor[first, 2, 1], factor[first, 2, 2]
            # The block L(k, i) = X Lᵢᵢ⁻ᵀ, row by row.
            a0 = work[i, 0] / l00
            a1 = (work[i, 1] - a0 * l10) / l11
            a2 = (work[i, 2] - a0 * l20 - a1 * l21) / l22
            b0 = work[i, 3] / l00
            b1 = (work[i, 4] - b0 * l10) / l11
            b2 = (work[i, 5] - b0 * l20 - b1 * l21) / l22
            c0 = work[i, 6] / l00
            c1 = (work[i, 7] - c0 * l10) / l11
            c2 = (work[i, 8] - c0 * l20 - c1 * l21) / l22
            for r in range(9):
                work[i, r] = 0.0
            multiplied += end[i] - first
            for p in range(first + 1, end[i]):
                j = factor_rows[p]
                f00, f01, f02 = factor[p, 0, 0], factor[p, 0, 1], factor[p, 0, 2]
                f10, f11, f12 = factor[p, 1, 0], factor[p, 1, 1], factor[p, 1, 2]
                f20, f21, f22 = factor[p, 2, 0], factor[p, 2, 1], factor[p, 2, 2]
                work[j, 0] -= a0 * f00 + a1 * f01 + a2 * f02
                work[j, 1] -= a0 * f10 + a1 * f11 + a2 * f12
                work[j, 2] -= a0 * f20 + a1 * f21 + a2 * f22
                work[j, 3] -= b0 * f00 + b1 * f01 + b2 * f02
                work[j, 4] -= b0 * f10 + b1 * f11 + b2 * f12
                work[j, 5] -= b0 * f20 + b1 * f21 + b2 * f22
                work[j, 6] -= c0 * f00 + c1 * f01 + c2 * f02
                work[j, 7] -= c0 * f10 + c1 * f11 + c2 * f12
                work[j, 8] -= c0 * f20 + c1 * f21 + c2 * f22
            d00 -= a0 * a0 + a1 * a1 + a2 * a2
            d10 -= b0 * a0 + b1 * a1 + b2 * a2
            d11 -= b0 * b0 + b1 * b1 + b2 * b2
            d20 -= c0 * a0 + c1 * a1 + c2 * a2
            d21 -= c0 * b0 + c1 * b1 + c2 * b2
            d22 -= c0 * c0 + c1 * c1 + c2 * c2
            p = end[i]
            end[i] += 1
            factor_rows[p] = k
            factor[p, 0, 0], factor[p, 0, 1], factor[p, 0, 2] = a0, a1, a2
            factor[p, 1, 0], factor[p, 1, 1], factor[p, 1, 2] = b0, b1, b2
            factor[p, 2, 0], factor[p, 2, 1], factor[p, 2, 2] = c0, c1, c2
        first = factor_starts[k]
        factor_rows[first] = k
        if not d00 > 0.0:
            failed[0] = k
            return n
        l00 = math.sqrt(d00)
        l10, l20 = d10 / l00, d20 / l00
        d11 -= l10 * l10
        if not d11 > 0.0:
            failed[0] = k
            return n
        l11 = math.sqrt(d11)
        l21 = (d21 - l20 * l10) / l11
        d22 -= l20 * l20 + l21 * l21
        if not d22 > 0.0:
            failed[0] = k
            return n
        factor[first, 0, 0], factor[first, 0, 1], factor[first, 0, 2] = l00, 0.0, 0.0
        factor[first, 1, 0], factor[first, 1, 1], factor[first, 1, 2] = l10, l11, 0.0
        factor[first, 2, 0], factor[first, 2, 1], factor[first, 2, 2] = l20, l21, math.sqrt(d22)
    return n


@jit
def solve_factorised(factor_starts: Int64Array, factor_rows: Int64Array, factor: Float64Array, x: Float64Array) -> None:
    """Solve L Lᵀ x = b in place: ``x`` (n, 3) holds b at the start and the solution at the end."""
    n = len(x)
    for k in range(n):
        p = factor_starts[k]
        x0 = x[k, 0] / factor[p, 0, 0]
        x1 = (x[k, 1] - factor[p, 1, 0] * x0) / factor[p, 1, 1]
        x2 = (x[k, 2] - factor[p, 2, 0] * x0 - factor[p, 2, 1] * x1) / factor[p, 2, 2]
        x[k, 0], x[k, 1], x[k, 2] = x0, x1, x2
        for q in range(p + 1, factor_starts[k + 1]):
            j = factor_rows[q]
            x[j, 0] -= factor[q, 0, 0] * x0 + factor[q, 0, 1] * x1 + factor[q, 0, 2] * x2
            x[j, 1] -= factor[q, 1, 0] * x0 + factor[q, 1, 1] * x1 + factor[q, 1, 2] * x2
            x[j, 2] -= factor[q, 2, 0] * x0 + factor[q, 2, 1] * x1 + factor[q, 2, 2] * x2
    for back in range(n):
        k = n - 1 - back
        p = factor_starts[k]
        x0, x1, x2 = x[k, 0], x[k, 1], x[k, 2]
        for q in range(p + 1, factor_starts[k + 1]):
            j = factor_rows[q]
            x0 -= factor[q, 0, 0] * x[j, 0] + factor[q, 1, 0] * x[j, 1] + factor[q, 2, 0] * x[j, 2]
            x1 -= factor[q, 0, 1] * x[j, 0] + factor[q, 1, 1] * x[j, 1] + factor[q, 2, 1] * x[j, 2]
            x2 -= factor[q, 0, 2] * x[j, 0] + factor[q, 1, 2] * x[j, 1] + factor[q, 2, 2] * x[j, 2]
        x[k, 2] = x2 / factor[p, 2, 2]
        x[k, 1] = (x1 - factor[p, 2, 1] * x[k, 2]) / factor[p, 1, 1]
        x[k, 0] = (x0 - factor[p, 1, 0] * x[k, 1] - factor[p, 2, 0] * x[k, 2]) / factor[p, 0, 0]
