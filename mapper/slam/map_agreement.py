"""Agreement of all scans of a map with one another, by which graphs of the same scans are compared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.slam.kernels.agreement import count_agreement
from mapper.slam.loop_test import GATE
from mapper.slam.scan_store import ScanStore
from mapper.slam.way_test import AROUND, EVERY, OTHERS, spread

#: Metres of the way: scans nearer than this agree whatever the loops are. Of scans within AROUND of one another those
#: farther apart were taken when the robot came back, also around a corner (√2 · AROUND of the way).
APART = 6.0
MOST_SCANS = 2_000  #: that are compared with others, so that the time grows with the number of scans
#: A map is inconsistent where the share of points that contradict scans from distant parts of the path is above
#: ``RATIO`` times the share that contradict scans from near parts, plus ``MORE``: near scans may agree perfectly.
RATIO, MORE = 2.5, 0.01
LEAST = 10  #: points that have to contradict: where the robot hardly came back, one of a few dozen is a large share


@dataclass(frozen=True, slots=True)
class MapAgreement:
    """Points compared with other scans: ``far`` (3,) with those far away on the way, ``near`` (3,) with those near.

    Each has the number of points that were compared, of those on a wall of the others, and of those in free space of
    the others.
    """

    far: tuple[int, int, int]
    near: tuple[int, int, int]

    @property
    def contradicted(self) -> float:
        """The share of points that contradict scans far away on the way, of those that these see; 0 without any."""
        return _share(self.far)

    @property
    def contradicted_near(self) -> float:
        """The share of points that contradict scans near on the way: what moves, glass, and noise."""
        return _share(self.near)

    @property
    def is_consistent(self) -> bool:
        """Whether about as many points contradict scans far away as scans near on the way, or hardly any do."""
        return self.far[2] < LEAST or self.contradicted <= RATIO * self.contradicted_near + MORE

    def score(self, loop_contradicted: float) -> float:
        """Return the score by which two graphs of the same scans are compared: the greater, the better.

        It is the number of points that agree with scans far away on the way, less those that contradict them, each of
        which counts as 1 / ``loop_contradicted`` points: a map in which that share contradicts scores less than one
        whose scans never meet again.
        """
        return self.far[1] - self.far[2] / max(loop_contradicted, 1e-3)


def map_agreement(store: ScanStore, poses: Float64Array) -> MapAgreement:
    """Return how the scans of a store agree with one another at ``poses`` (n, 3), ``T_map_base``.

    Every metre of the way a scan is compared with those taken near its pose, as
    :func:`mapper.slam.kernels.agreement.count_agreement` counts: with those within :data:`APART` metres of the way
    before or after it, and with those farther away.
    """
    driven = np.r_[0.0, np.cumsum(np.hypot(*np.diff(poses[:, :2], axis=0).T))]
    step = max(EVERY, float(driven[-1]) / MOST_SCANS)
    counts = np.empty(3, dtype=np.int64)
    far, near = np.zeros(3, dtype=np.int64), np.zeros(3, dtype=np.int64)
    for k in np.unique(np.searchsorted(driven, np.arange(0.0, driven[-1], step))).tolist():
        around = np.hypot(*(poses[:, :2] - poses[k, :2]).T) < AROUND
        around[k] = False
        is_far = np.abs(driven - driven[k]) > APART
        if (around & is_far).any():
            others = spread(np.flatnonzero(around & is_far), OTHERS)
            count_agreement(store.arrays, k, poses[k], others, poses, GATE, 2, counts)
            far += counts
        if (around & ~is_far).any():
            others = spread(np.flatnonzero(around & ~is_far), OTHERS)
            count_agreement(store.arrays, k, poses[k], others, poses, GATE, 2, counts)
            near += counts
    return MapAgreement(_three(far), _three(near))


def _share(counts: tuple[int, int, int]) -> float:
    """Return the share of contradicting points among those that agree or contradict.

    Where the robot comes back from another side most points are out of the sight of the scans there, and say nothing.
    """
    _, agreeing, contradicting = counts
    return contradicting / max(agreeing + contradicting, 1)


def _three(counts: Int64Array) -> tuple[int, int, int]:
    first, second, third = counts.tolist()
    return first, second, third
