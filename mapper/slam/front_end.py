"""The front end: each new scan aligned with the scans shortly before it.

Its poses are in a frame of their own that no loop closure moves, so that it can run ahead of the graph.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import between_one, compose_one
from mapper.matching.kernels.point_to_line import refine_pose
from mapper.slam.config import SlamConfig
from mapper.slam.fields import ScoreField
from mapper.slam.kernels.agreement import count_agreement
from mapper.slam.matching_rules import (
    CORRELATION,
    FRONT_ITERATIONS,
    LEAST_PAIRS,
    NOISE,
    information_of,
    pair_rule,
)
from mapper.slam.scan_store import ScanStore

Float64Array = NDArray[np.float64]

RESOLUTION, SIGMA, TURN = 0.05, 0.08, np.radians(1.0)
GATE = 0.15  #: metres: points nearer than this to one another are on the same wall
LEAST_INLIERS = 0.5
LEAST_SCORE = 0.5  #: of the correlation, for its pose to count where the alignment failed


@dataclass(frozen=True, slots=True)
class Step:
    """What the front end found of one scan: ``relative`` (3,) to the scan before, with ``information`` (3, 3).

    Of its points that agree with the scans before or contradict them, ``inliers`` is the share that agree;
    ``is_aligned`` says that they were enough, otherwise the motion is the correlation's or the predicted one.
    """

    relative: Float64Array
    information: Float64Array
    inliers: float
    is_aligned: bool


class FrontEnd:
    """Aligns scans one after another. ``poses`` (n, 3) are theirs in the front end's frame."""

    def __init__(self, store: ScanStore, config: SlamConfig) -> None:
        self._store = store
        self._config = config
        self._poses = np.zeros((512, 3))
        self._n = 0
        self._half = int(config.submap_scans)
        self._fields: list[tuple[ScoreField, int]] = []  # with the first scan of each
        self._motion = np.zeros(3)
        self.submaps: list[tuple[int, int]] = []  #: finished ones: first scan and the one after the last

    def __len__(self) -> int:
        return self._n

    @property
    def poses(self) -> Float64Array:
        """Return the poses so far (n, 3), ``T_local_base``."""
        return self._poses[: self._n]

    def add(self, ranges: NDArray[np.float32], motion: Float64Array | None) -> Step:
        """Align the next scan; ``motion`` (3,) is the odometry's since the one before, None for no odometry."""
        i = self._store.append(ranges)
        if self._n == len(self._poses):
            self._poses = np.concatenate([self._poses, np.zeros_like(self._poses)])
        if i == 0:
            step = Step(np.zeros(3), np.eye(3), 1.0, True)
        else:
            step = self._align(i, motion)
            self._poses[i] = compose_one(self._poses[i - 1].tolist(), step.relative.tolist())
        self._n += 1
        self._draw(i)
        return step

    def _align(self, i: int, motion: Float64Array | None) -> Step:
        # Without odometry the robot is taken to move on as before.
        expected = self._motion if motion is None else motion
        way, turned = math.hypot(expected[0], expected[1]), abs(float(expected[2]))
        before = self._poses[i - 1]
        predicted = np.array(compose_one(before.tolist(), expected.tolist()))
        if motion is None:
            window, turn_window = 0.25 + 0.5 * way, 0.15 + 0.5 * turned
            spread = np.array([0.05 + 0.5 * way] * 2 + [0.03 + 0.5 * turned])
        else:
            window, turn_window = 0.10 + 0.2 * way, 0.07 + 0.2 * way + 0.2 * turned
            spread = np.array([0.03 + 0.15 * way] * 2 + [0.02 + 0.15 * way + 0.1 * turned])
        scans = self._store.arrays
        found, score, _ = self._fields[0][0].search(
            scans, i, predicted, min(window, 0.6), min(turn_window, 0.5), TURN, 2
        )
        pose = found.copy()
        hessian = np.empty((3, 3))
        weight = NOISE**2 / CORRELATION / spread**2
        neighbours = np.arange(max(self._fields[0][1], i - int(self._config.neighbours)), i)
        pairs = refine_pose(
            scans,
            i,
            scans,
            neighbours,
            self._poses,
            predicted,
            weight,
            pair_rule(scans),
            FRONT_ITERATIONS,
            pose,
            hessian,
        )[0]
        counts = np.empty(3, dtype=np.int64)
        count_agreement(scans, i, pose, neighbours, self._poses, GATE, 1, counts)
        inliers = counts[1] / max(counts[1] + counts[2], 1)
        aligned = pairs >= LEAST_PAIRS and inliers > LEAST_INLIERS
        if aligned:
            information = information_of(hessian, float(pose[2]), weight)
        else:
            pose = found if score > LEAST_SCORE else predicted
            information = np.diag(1.0 / (3.0 * spread) ** 2)
        relative = np.array(between_one(before.tolist(), pose.tolist()))
        self._motion = relative if aligned else expected
        return Step(relative, information, inliers, aligned)

    def _draw(self, i: int) -> None:
        """Draw scan i into the fields, and exchange them when they are full."""
        if not self._fields:
            self._begin(i)
        else:
            for field, _ in self._fields:
                field.add(self._store.arrays, i, self._poses[i])
        held = i + 1 - self._fields[0][1]
        if held >= 2 * self._half:
            self.submaps.append((self._fields[0][1], i + 1))
            del self._fields[0]
            self._begin(i)
        elif len(self._fields) == 1 and held >= self._half:
            self._begin(i)

    def _begin(self, i: int) -> None:
        reach = min(self._store.farthest(i) + 5.0, self._config.range_max + 5.0)
        field = ScoreField(self._poses[i, :2], max(reach, 10.0), RESOLUTION, SIGMA)
        field.add(self._store.arrays, i, self._poses[i])
        self._fields.append((field, i))
