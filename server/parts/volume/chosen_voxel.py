"""The voxel that is asked about, and its beams, as drawings."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float32Array
from server.sessions.drawings import CHOSEN, Drawing, Segments

HIT, PASSED = (214, 92, 30), (60, 130, 200)
MOST_SCANS, MOST_BEAMS = 200, 2000  #: whose beams are drawn, the newest
#: Whether they ended in a voxel or passed it, the place of the sensor (3,), their ends (n, 3).
Beams = tuple[bool, NDArray[np.floating[Any]] | None, NDArray[np.floating[Any]]]


class ChosenVoxel:
    """Its :attr:`drawings`; none while no voxel is chosen."""

    def __init__(self) -> None:
        self.drawings: list[Drawing] = []

    def choose(self, centre: Float32Array | None, size: float, beams: Sequence[Beams] = ()) -> None:
        """Show the voxel at ``centre`` (3,), ``size`` metres wide, and the beams that ended in it or passed it.

        None for no voxel.
        """
        self.drawings = []
        if centre is None:
            return
        corners = np.array(list(product((-0.5, 0.5), repeat=3)), dtype=np.float32) * 1.04
        edges = [(a, b) for a in range(8) for b in range(a + 1, 8) if (a ^ b).bit_count() == 1]
        box = centre + size * corners[np.array(edges)]
        self.drawings.append(
            Segments(name="chosen", label="Chosen voxel", points=box.astype(np.float32), colors=CHOSEN, width=3.0)
        )
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
