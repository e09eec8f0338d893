"""The largest group of measurements of which each two are consistent.

Source: Mangelson et al. 2018, Pairwise consistent measurement set maximization for robust multi-robot map merging.
"""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import BoolArray, Int64Array

MOST_STEPS = 20_000  #: of the search, after which the largest group so far counts


def largest_consistent(consistent: BoolArray) -> Int64Array:
    """Return the numbers of the largest group (k,), in ascending order; ``consistent`` (n, n) is symmetric.

    It is a maximum clique, found with Bron and Kerbosch's algorithm with pivots (Tomita 2006) and a bound; of equally
    large ones the first that is found.
    """
    n = len(consistent)
    others = [
        {int(k) for k in np.flatnonzero(row)} - {i} for i, row in enumerate(np.asarray(consistent, dtype=np.bool_))
    ]
    best: list[int] = []
    steps = 0
    # Of each open branch: the group so far, what can still be added, and what was tried before.
    stack: list[tuple[list[int], set[int], set[int]]] = [([], set(range(n)), set())]
    while stack and steps < MOST_STEPS:
        steps += 1
        group, open_, tried = stack.pop()
        if len(group) > len(best):
            best = group
        if len(group) + len(open_) <= len(best):
            continue
        pivot = max(sorted(open_ | tried), key=lambda k: len(open_ & others[k]))
        branches = []
        for k in sorted(open_ - others[pivot]):
            branches.append(([*group, k], open_ & others[k], tried & others[k]))
            open_ = open_ - {k}
            tried = tried | {k}
        stack += reversed(branches)
    return np.array(sorted(best), dtype=np.int64)
