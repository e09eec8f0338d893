"""Drawings of the queried voxel and its beams."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.core.array_types import Float32Array
from server.sessions.drawings import CHOSEN, Drawing, Segments

HIT, PASSED = (214, 92, 30), (60, 130, 200)
MOST_SCANS, MOST_BEAMS = 200, 2000  #: maximum numbers for which beams are drawn, the newest
#: Whether they ended in the voxel or passed through it, the place of the sensor (3,), their ends (n, 3).
Beams = tuple[bool, NDArray[np.floating[Any]] | None, NDArray[np.floating[Any]]]


def box_edges(low: ArrayLike, high: ArrayLike) -> Float32Array:
    """Return the edges (12, 2, 3) of a box from ``low`` to ``high`` (3,)."""
    ends = np.array([low, high], dtype=np.float32)
    corners = np.array([[ends[n >> axis & 1, axis] for axis in range(3)] for n in range(8)], dtype=np.float32)
    edges = [(a, b) for a in range(8) for b in range(a + 1, 8) if (a ^ b).bit_count() == 1]
    return np.asarray(corners[np.array(edges)])


class ChosenVoxel:
    """The queried voxel's :attr:`drawings`; empty while no voxel is chosen."""

    def __init__(self) -> None:
        self.drawings: list[Drawing] = []

    def choose(self, centre: Float32Array | None, size: float, beams: Sequence[Beams] = ()) -> None:
        """Show the voxel at ``centre`` (3,), ``size`` metres wide, and the beams that ended in it or passed through it.

        None removes it.
        """
        self.drawings = []
        if centre is None:
            return
        box = box_edges(centre - 0.52 * size, centre + 0.52 * size)
        self.drawings.append(Segments(name="chosen", label="Chosen voxel", points=box, colors=CHOSEN, width=3.0))
        for name, is_hit, color in (("hits", True, HIT), ("passes", False, PASSED)):
            rays = [
                np.stack([np.broadcast_to(origin, ends.shape), ends], axis=1)
                for ended, origin, ends in beams[-MOST_SCANS:]
                if ended == is_hit and origin is not None and len(ends)
            ]
            if rays:
                lines = np.concatenate(rays).astype(np.float32)[-MOST_BEAMS:]
                self.drawings.append(
                    Segments(name=name, label="Beams that ended in it" if is_hit else "Beams that passed it",
                             points=lines, colors=color, width=1.5)
                )  # fmt: skip
