"""Score fields of submaps, and the search for a scan's pose in them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.grid.kernels.lattice import Frame
from mapper.matching.fields import GREATEST, gaussian_stamps
from mapper.matching.kernels.correlative import Window, best_in_window, branch_and_bound, score_window
from mapper.matching.kernels.score_field import add_scan, write_pyramid
from mapper.matching.kernels.types import ScanArrays


class ScoreField:
    """A square of ``2 · reach`` metres around ``centre`` (2,), into which scans are drawn."""

    def __init__(self, centre: Float64Array, reach: float, resolution: float, sigma: float) -> None:
        side = max(8, int(np.ceil(2.0 * reach / resolution)))
        self.scores = np.zeros((side, side), dtype=np.uint8)
        half = 0.5 * side * resolution
        self.frame = Frame(float(centre[0] - half), float(centre[1] - half), 1.0, 0.0, resolution)
        self._stamps = gaussian_stamps(resolution, sigma)

    def add(self, scans: ScanArrays, i: int, pose: Float64Array) -> None:
        """Draw scan i at ``pose`` (3,)."""
        add_scan(self.scores, self.frame, self._stamps, scans, i, pose, 1)

    def search(
        self, scans: ScanArrays, i: int, pose: Float64Array, window: float, turn_window: float, turn: float, stride: int
    ) -> tuple[Float64Array, float, float]:
        """Return the best pose (3,) within ``window`` metres and ``turn_window`` radians, its score and ``pose``'s.

        Scores are fractions, 0 to 1, of the maximum possible; headings are ``turn`` radians apart. Every pose is
        scored.
        """
        cells, turns = int(np.ceil(window / self.frame.resolution)), int(np.ceil(turn_window / turn))
        volume = np.empty((2 * turns + 1, 2 * cells + 1, 2 * cells + 1), dtype=np.int32)
        box = Window(cells, turns, turn)
        n = score_window(self.scores, self.frame, scans, i, pose, box, stride, volume)
        best = np.empty(4, dtype=np.int64)
        best_in_window(volume, best)
        whole = float(GREATEST * max(n, 1))
        return self._moved(pose, best, turn), float(best[0]) / whole, float(volume[turns, cells, cells]) / whole

    def pyramid(self, levels: int) -> NDArray[np.uint8]:
        """Return the grids (levels + 1, rows, cols) for :meth:`search_pyramid`."""
        out = np.empty((levels + 1, *self.scores.shape), dtype=np.uint8)
        write_pyramid(self.scores, out)
        return out

    def search_pyramid(
        self,
        levels: NDArray[np.uint8],
        scans: ScanArrays,
        i: int,
        pose: Float64Array,
        window: float,
        turn_window: float,
        turn: float,
        stride: int,
        least: float,
    ) -> tuple[Float64Array, float]:
        """Return the result of :meth:`search`, by branch and bound; score 0 if no pose reaches ``least``."""
        cells, turns = int(np.ceil(window / self.frame.resolution)), int(np.ceil(turn_window / turn))
        best = np.empty(4, dtype=np.int64)
        points = int(np.count_nonzero(scans.kind[i, ::stride]))
        floor = int(least * GREATEST * points)
        n = branch_and_bound(levels, self.frame, scans, i, pose, Window(cells, turns, turn), stride, floor, best)
        if best[0] < 0:
            return pose.copy(), 0.0
        return self._moved(pose, best, turn), float(best[0]) / float(GREATEST * max(n, 1))

    def _moved(self, pose: Float64Array, best: NDArray[np.int64], turn: float) -> Float64Array:
        resolution = self.frame.resolution
        return np.array(
            [pose[0] + best[3] * resolution, pose[1] + best[2] * resolution, pose[2] + best[1] * turn],
        )
