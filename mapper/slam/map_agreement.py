"""Agreement of all scans of a map with each other, used to compare graphs of the same scans."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.slam.kernels.agreement import count_agreement
from mapper.slam.loop_test import GATE
from mapper.slam.scan_store import ScanStore
from mapper.slam.way_test import AROUND, EVERY, OTHERS, spread

#: Metres of path: scans nearer than this agree regardless of the loops. Of scans within AROUND of each other, those
#: farther apart along the path were taken when the robot returned, also around a corner (√2 · AROUND of path).
APART = 6.0
MOST_SCANS = 2_000  #: number compared with others, so that the time is linear in the number of scans
#: A map is inconsistent where the share of points that contradict scans from distant parts of the path is above
#: ``RATIO`` times the share that contradict scans from near parts, plus ``MORE``: near scans may agree perfectly.
RATIO, MORE = 2.5, 0.01
LEAST = 10  #: minimum number of contradicting points: with few revisits, one of a few dozen is a large fraction


@dataclass(frozen=True, slots=True)
class MapAgreement:
    """Points compared with other scans: ``far`` (3,) with scans far away along the path, ``near`` (3,) with near ones.

    Each has the number of points compared, on a wall of the others, and in free space of the others.
    """

    far: tuple[int, int, int]
    near: tuple[int, int, int]

    @property
    def contradicted(self) -> float:
        """Fraction of points that contradict scans far along the path, among those visible to them; 0 if none."""
        return _share(self.far)

    @property
    def contradicted_near(self) -> float:
        """Fraction of points that contradict scans near along the path, due to moving objects, glass and noise."""
        return _share(self.near)

    @property
    def is_consistent(self) -> bool:
        """Whether scans far along the path are contradicted about as often as near ones, or hardly at all."""
        return self.far[2] < LEAST or self.contradicted <= RATIO * self.contradicted_near + MORE

    def score(self, loop_contradicted: float) -> float:
        """Return the score by which two graphs of the same scans are compared; greater is better.

        It is the number of points that agree with scans far along the path, minus 1 / ``loop_contradicted`` for each
        that contradicts them: a map in which that fraction contradicts scores less than one whose scans never meet
        again.
        """
        return self.far[1] - self.far[2] / max(loop_contradicted, 1e-3)


def map_agreement(store: ScanStore, poses: Float64Array) -> MapAgreement:
    """Return the agreement of the scans of a store at ``poses`` (n, 3), ``T_map_base``.

    For every metre of path one scan is compared with those taken near its pose
    (:func:`mapper.slam.kernels.agreement.count_agreement`): separately with those within :data:`APART` metres along the
    path and those farther away.
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
    """Return the fraction of contradicting points among those that agree or contradict.

    If the robot returns from another side, most points are not visible to the scans there and are not counted.
    """
    _, agreeing, contradicting = counts
    return contradicting / max(agreeing + contradicting, 1)


def _three(counts: Int64Array) -> tuple[int, int, int]:
    first, second, third = counts.tolist()
    return first, second, third
