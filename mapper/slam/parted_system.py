"""Solution of a large system of poses part by part, in bounded memory.

Source: Saad 2003, Iterative Methods for Sparse Linear Systems, section 4.1.1, block Gauss–Seidel: the poses of a part
are solved for exactly while the others keep their steps so far.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.slam.sparse_system import SparseSystem


class PartedSystem:
    """The system H Δ = b of poses (n, 3) that ``pairs`` (p, 2) of them contribute to; pose ``fixed`` does not move.

    Up to ``most`` poses are one :class:`SparseSystem`, and its solution is exact. More are divided by place into parts
    of at most ``most``, one of which is held in memory at a time; each :meth:`solve` is one sweep over them, in the
    opposite order of the one before.
    """

    def __init__(self, poses: Float64Array, pairs: Int64Array, most: int, fixed: int = 0) -> None:
        self._n, self._pairs, self._fixed = len(poses), pairs, fixed
        self.parts = divided(poses[:, :2], most)
        self._whole = SparseSystem(self._n, pairs, np.array([fixed])) if len(self.parts) == 1 else None
        self.filled = 0  #: blocks of the largest factor so far

    def solve(
        self,
        hessians: Float64Array,
        gradients: Float64Array,
        damping: float = 0.0,
        check: Callable[[], None] | None = None,
    ) -> Float64Array:
        """Return Δ (n, 3), as :meth:`SparseSystem.solve` does, after one sweep."""
        if self._whole is not None:
            self.filled = self._whole.filled
            return self._whole.solve(hessians, gradients, damping, check)
        step = np.zeros((self._n, 3))
        for part in self.parts:
            inside = np.zeros(self._n, dtype=np.bool_)
            inside[part] = True
            inside[self._fixed] = False
            rows = np.flatnonzero(inside[self._pairs].any(axis=1))
            pairs, blocks = self._pairs[rows], hessians[rows]
            known = step[pairs].reshape(-1, 6)
            sides = gradients[rows] - np.einsum("kab,kb->ka", blocks, known)
            system = SparseSystem(self._n, pairs, np.flatnonzero(~inside))
            step[inside] = system.solve(blocks, sides, damping, check)[inside]
            self.filled = max(self.filled, system.filled)
        self.parts.reverse()
        return step


def divided(places: Float64Array, most: int) -> list[Int64Array]:
    """Return the numbers of places (n, 2), in parts of at most ``most``: halved across the longer side until they are.

    The numbers of a part ascend.
    """
    parts = [np.arange(len(places), dtype=np.int64)]
    done: list[Int64Array] = []
    while parts:
        part = parts.pop()
        if len(part) <= most:
            done.append(part)
            continue
        along = places[part, int(np.argmax(np.ptp(places[part], axis=0)))]
        order = np.argsort(along, kind="stable")
        parts += [np.sort(part[order[len(part) // 2 :]]), np.sort(part[order[: len(part) // 2]])]
    return done
