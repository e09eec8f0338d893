"""SLAM front end: aligns each new scan with the scans shortly before it.

Its poses are in a separate frame that loop closures do not move, so it can run ahead of the graph.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
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

#: metres, metres, radians: of the field and the steps of the search; a rotation by 1° moves a wall 5 m away by one
#: sigma
RESOLUTION, SIGMA, TURN = 0.05, 0.08, np.radians(1.0)
GATE = 0.15  #: metres: points closer than this are on the same wall
LEAST_INLIERS = 0.5  #: of the informative points: if most contradict, the pose is wrong
RELIABLE, FAIR = 0.85, 0.5  #: agreement above which nothing is searched, and above which no wider window is
BETTER = 0.03  #: minimum gain in agreement of a searched pose over the predicted one
WIDER = 3.0  #: size of the second window relative to the first
WIDEST, WIDEST_TURN = 1.0, 0.7  #: metres, radians: maximum of any window, to each side
MARGIN = 5.0  #: metres around the view of a submap's first scan
POINTS = 720  #: maximum number of a scan's points that are paired
SEARCHED = 90  #: maximum number of a scan's points used in a search
SOON = 0.3  #: seconds for which the previous motion predicts a scan well if the last one fitted
LONGEST = 1.0  #: seconds: maximum time for which the motion is extrapolated
FARTHEST = np.array([3.0, 3.0, 1.5])  #: metres, metres, radians: limit of extrapolation, as stamps may be wrong
MOST_SPREAD = np.array([10.0, 10.0, np.pi])  #: metres, metres, radians: maximum uncertainty of a motion
LEAST_SCORE = 0.5  #: of the correlation, for its pose to be used if the alignment failed


@dataclass(frozen=True, slots=True)
class Step:
    """Result of the front end for one scan: ``relative`` (3,) to the kept scan before, with ``information`` (3, 3).

    ``is_kept`` means that later scans are aligned with it; otherwise only its pose is used. ``inliers`` is the fraction
    of points that agree, among those that agree with or contradict the scans before. ``is_aligned`` means that it was
    large enough; otherwise the motion is the correlation's or the predicted one. ``agreement`` is ``inliers`` times the
    fraction of all points that agree.
    """

    relative: Float64Array
    information: Float64Array
    inliers: float
    is_aligned: bool
    agreement: float
    is_kept: bool = True


@dataclass(frozen=True, slots=True)
class _Attempt:
    """A scan aligned from ``start`` (3,) with correlation ``score``, 0 if nothing was searched.

    ``agreement`` is the fraction of all points that agree times ``inliers``, the fraction that agree among those that
    agree or contradict.
    """

    start: Float64Array
    score: float
    pose: Float64Array
    hessian: Float64Array
    prior: Float64Array
    inliers: float
    agreement: float
    is_aligned: bool


class FrontEnd:
    """Aligns scans one after another. ``poses`` (n, 3) are those of the kept scans in the front end's frame.

    ``last`` (3,) is the pose of the newest scan, kept or not.
    """

    def __init__(self, store: ScanStore, config: SlamConfig) -> None:
        self._store = store
        self._config = config
        self._poses = np.zeros((512, 3))
        self._n = 0
        self._half = int(config.submap_scans) * store.n_sensors
        self._seen: list[int] = []  # scans with points
        # This many points are enough to align a scan; the joint refinement uses all of them.
        stride = max(1, store.n_beams * int(config.neighbours) // POINTS)
        self._rule = pair_rule(store.least_step)._replace(stride=stride)
        self._begun: list[int] = []  # first scans of the unfinished submaps, at most two
        self._drawn: tuple[int, int, ScoreField] | None = None  # first scan, end of the scans, and their field
        self.last = np.zeros(3)
        self._motion = np.zeros(3)
        self._kept_of: dict[int, int] = {}  # the newest kept scan of each sensor
        self._velocity: Float64Array | None = None  # the last known velocity
        self._is_reliable = False  # whether the last scan fitted well
        self._is_steady = False  # whether the motion of the last scans predicts the next pose well
        self._many = store.n_sensors  # number of scans needed to see in all directions
        # Times of the last scans, seconds, if known, and their poses.
        self._track: deque[tuple[float, Float64Array]] = deque(maxlen=self._many + 1)
        self.submaps: list[tuple[int, int]] = []  #: finished submaps: first scan and end

    def __len__(self) -> int:
        return self._n

    @property
    def poses(self) -> Float64Array:
        """Return the poses so far (n, 3), ``T_local_base``."""
        return self._poses[: self._n]

    @property
    def velocity(self) -> Float64Array | None:
        """The velocity (3,) of the last step, metres and radians per second; None if it is not well known."""
        return self._velocity if self._is_reliable else None

    def add(
        self,
        ranges: NDArray[np.float32],
        motion: Float64Array | None,
        *,
        sensor: int = 0,
        seconds: float | None = None,
        velocity: Float64Array | None = None,
        may_drop: bool = False,
        mount: Float64Array | None = None,
    ) -> Step:
        """Align the next scan. ``motion`` (3,) is the odometry's since the scan before, None for no odometry.

        With ``may_drop``, a scan that fits well and was taken close to its sensor's previous kept scan, by the config's
        distance and turn of nodes, is not kept. ``seconds`` is the time since the scan before, None if unknown.
        ``sensor``, ``velocity`` and ``mount`` are as in :meth:`ScanStore.append`; without a velocity, that of the
        previous steps is used.
        """
        expected = self._expected(seconds) if motion is None else motion
        if velocity is None:
            velocity = expected / seconds if motion is not None and seconds else self._velocity
        i = self._store.append(ranges, sensor, velocity, mount)
        if self._n == len(self._poses):
            self._poses = np.concatenate([self._poses, np.zeros_like(self._poses)])
        if i == 0:
            step = Step(np.zeros(3), np.eye(3), 1.0, True, 1.0)
            self._track.append((0.0, self.last))
        else:
            is_steady = self._is_steady and seconds is not None and seconds <= SOON
            step = self._align(i, expected, has_odometry=motion is not None, is_steady=is_steady)
            before, self.last = self.last, np.array(compose_one(self._poses[i - 1].tolist(), step.relative.tolist()))
            self._motion = np.array(between_one(before.tolist(), self.last.tolist())) if step.is_aligned else expected
            self._is_reliable = step.is_aligned and step.agreement >= FAIR
            self._note_velocity(seconds)
            self._is_steady = self._velocity is not None and step.agreement >= RELIABLE
            self._poses[i] = self.last
        if may_drop and step.agreement >= RELIABLE and self._is_near(sensor):
            self._store.drop_last()
            return replace(step, is_kept=False)
        self._kept_of[self._store.sensor_numbers[sensor]] = i
        self._n += 1
        if self._store.count(i) >= LEAST_PAIRS:
            self._seen.append(i)
        self._divide()
        return step

    def _expected(self, seconds: float | None) -> Float64Array:
        """Return the motion in ``seconds`` at the current velocity."""
        if seconds is None or self._velocity is None:
            return self._motion
        return np.clip(self._velocity * min(seconds, LONGEST), -FARTHEST, FARTHEST)

    def _is_near(self, sensor: int) -> bool:
        """Return whether the newest scan was taken close to its sensor's previous kept scan."""
        keyframes = self._kept_of.get(self._store.sensor_numbers[sensor])
        if keyframes is None:
            return False
        x, y, yaw = between_one(self._poses[keyframes].tolist(), self.last.tolist())
        return math.hypot(x, y) < self._config.node_distance and abs(yaw) < self._config.node_turn

    def _note_velocity(self, seconds: float | None) -> None:
        """Update the velocity from the last scans of all sensors, because two sensors may scan at nearly the same
        time.
        """
        self._track.append((self._track[-1][0] + (seconds or 0.0), self.last))
        then, before = self._track[0]
        passed = self._track[-1][0] - then
        self._velocity = None
        if seconds is not None and passed > 0.0:
            self._velocity = np.array(between_one(before.tolist(), self.last.tolist())) / passed

    def _align(self, i: int, expected: Float64Array, *, has_odometry: bool, is_steady: bool) -> Step:
        length, turned = math.hypot(expected[0], expected[1]), abs(float(expected[2]))
        predicted = np.array(compose_one(self.last.tolist(), expected.tolist()))
        if not has_odometry:
            window, turn_window = 0.25 + 0.5 * length, 0.15 + 0.5 * turned
            spread = np.array([0.05 + 0.5 * length] * 2 + [0.03 + 0.5 * turned])
        else:
            window, turn_window = 0.10 + 0.2 * length, 0.07 + 0.2 * length + 0.2 * turned
            spread = np.array([0.03 + 0.15 * length] * 2 + [0.02 + 0.15 * length + 0.1 * turned])
        spread = np.minimum(spread, MOST_SPREAD)
        # If the prediction leads to a good alignment, nothing is searched. In a corridor, along which every position
        # fits equally well, the prediction is then used. Without odometry it is too poor for that, except shortly after
        # a scan that fitted well.
        if not has_odometry and not is_steady:
            enough, best = RELIABLE, self._searched(i, predicted, spread, window, turn_window)
        else:
            enough, best = FAIR, self._refined(i, predicted, predicted, spread, 0.0)
            if best.agreement < RELIABLE:
                best = _better(best, self._searched(i, predicted, spread, window, turn_window))
        if best.agreement < enough:
            best = _better(best, self._searched(i, predicted, spread, WIDER * window, WIDER * turn_window))
        if best.is_aligned:
            pose, information = best.pose, information_of(best.hessian, float(best.pose[2]), best.prior)
        else:
            pose = best.start if best.score > LEAST_SCORE else predicted
            information = np.diag(1.0 / (3.0 * spread) ** 2)
        relative = np.array(between_one(self._poses[i - 1].tolist(), pose.tolist()))
        return Step(relative, information, best.inliers, best.is_aligned, best.agreement)

    def _searched(
        self, i: int, predicted: Float64Array, spread: Float64Array, window: float, turn_window: float
    ) -> _Attempt:
        """Align scan i from the best pose in a window around the predicted one."""
        stride = max(2, self._store.count(i) // SEARCHED)
        start, score, _ = self._field().search(
            self._store.arrays, i, predicted, min(window, WIDEST), min(turn_window, WIDEST_TURN), TURN, stride
        )
        return self._refined(i, start, predicted, spread, score)

    def _refined(
        self, i: int, start: Float64Array, predicted: Float64Array, spread: Float64Array, score: float
    ) -> _Attempt:
        scans = self._store.arrays
        pose, hessian, prior = start.copy(), np.empty((3, 3)), NOISE**2 / CORRELATION / spread**2
        others = np.array(self._seen[-int(self._config.neighbours) * self._many :], dtype=np.int64)
        pairs = refine_pose(
            scans, i, scans, others, self._poses, predicted, prior, self._rule, FRONT_ITERATIONS, pose, hessian
        )[0]
        counts = np.empty(3, dtype=np.int64)
        count_agreement(scans, i, pose, others, self._poses, GATE, 1, counts)
        points, agreeing, contradicting = counts.tolist()
        inliers = agreeing / max(agreeing + contradicting, 1)
        aligned = pairs >= LEAST_PAIRS and inliers > LEAST_INLIERS
        return _Attempt(start, score, pose, hessian, prior, inliers, inliers * agreeing / max(points, 1), aligned)

    def _field(self) -> ScoreField:
        """Return the score field of the scans of the last submap but one, or the last, up to the newest scan."""
        if self._drawn is None or self._drawn[0] != self._begun[0]:
            first = self._begun[0]
            reach = max(self._store.farthest(k) for k in (first, self._n - 1)) + MARGIN
            field = ScoreField(self._poses[first, :2], min(reach, self._config.range_max + MARGIN), RESOLUTION, SIGMA)
            self._drawn = (first, first, field)
        first, drawn, field = self._drawn
        for k in range(drawn, self._n):
            field.add(self._store.arrays, k, self._poses[k])
        self._drawn = (first, self._n, field)
        return field

    def _divide(self) -> None:
        """Start and finish submaps after a scan was added."""
        if not self._begun:
            self._begun = [0]
        elif len(self._begun) == 1 and self._n - self._begun[0] >= self._half:
            self._begun.append(self._n - 1)
        elif self._n - self._begun[0] >= 2 * self._half:
            self.submaps.append((self._begun[0], self._n))
            self._begun = [self._begun[1], self._n - 1]


def _better(first: _Attempt, second: _Attempt) -> _Attempt:
    """Return the second attempt if it agrees clearly better, else the first."""
    return second if second.agreement > first.agreement + BETTER else first
