"""Shortest paths between the nodes of a pose graph, with which the uncertainty between two poses grows."""

from __future__ import annotations

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.jit import jit


@jit
def ways_from(start: int, driven: Float64Array, first: Int64Array, second: Int64Array, out: Float64Array) -> None:
    """Write the length (n,) of the shortest path from node ``start`` to each node, metres.

    ``driven`` (n,) is the distance driven up to each node, which gives the lengths along the chain. The loops from
    ``first`` (l,) to ``second`` (l,) have length 0. Bellman–Ford algorithm, in sweeps along the chain.
    """
    n = len(driven)
    for k in range(n):
        out[k] = abs(driven[start] - driven[k])
    changed = True
    while changed:
        changed = False
        for k in range(len(first)):
            i, j = first[k], second[k]
            if out[i] < out[j]:
                out[j] = out[i]
                changed = True
            elif out[j] < out[i]:
                out[i] = out[j]
                changed = True
        if changed:
            for k in range(1, n):
                out[k] = min(out[k], out[k - 1] + driven[k] - driven[k - 1])
            for k in range(n - 2, -1, -1):
                out[k] = min(out[k], out[k + 1] + driven[k + 1] - driven[k])


@jit
def least_of_ranges(values: Float64Array, begin: Int64Array, end: Int64Array, at: Int64Array) -> None:
    """Write the index of the minimum of ``values`` in each range [``begin``, ``end``) (r,)."""
    for k in range(len(begin)):
        best = begin[k]
        for i in range(begin[k], end[k]):
            if values[i] < values[best]:
                best = i
        at[k] = best
