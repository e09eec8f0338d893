"""Agreement of a log's readings, depending on the assumed measurement times of beams and poses.

Where the robot turns, beams placed at wrong times end off the walls seen by other beams where it hardly moved.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose
from mapper.sensors.motion import Motion, seconds
from mapper.sensors.scan import ScanLog

STRETCH = 40  #: consecutive scans that are compared with each other; poses drift little meanwhile
SHORTER = 20  #: the same for a short log with few turns, for more stretches
MOST_STRETCHES = 6  #: stretches examined, those with the most motion
FAST, LEAST_STILL, MOST_STILL = 5, 4, 10  #: scans of each stretch with the most motion, and with hardly any
LEAST_STRETCHES = 2  #: minimum number
MOST_BEAMS = 360  #: of each scan
FEWER_BEAMS = 120  #: of each scan, for the coarse search
REACH_M = 3.0  #: lever arm: a turn of 1 rad moves the end of a beam by this distance
LEAST_MOVED_M = 0.05  #: minimum motion of a beam's end within the time span, for the comparison to be conclusive
STILL = 0.5  #: maximum fraction of that motion in scans at rest
FARTHEST_M = 0.3  #: from the nearest end of another beam: what is farther was not seen by others
BETTER, BY_M = 0.75, 0.01  #: ratio, and difference, by which beams must end nearer to others with other times
MUCH = 0.5  #: ratio if nothing was stated that the readings contradict
DELAYS_S = tuple(0.05 * k for k in range(-6, 7))  #: of the scans, among which the best fit is searched
FINER_S = (0.025, 0.0125, 0.00625)  #: steps of the fine search around the best of them


def fits(error: float, other: float, share: float = BETTER) -> bool:
    """Return whether ``error`` metres is clearly less than ``other`` metres, the distance with other times."""
    return error <= share * other and error <= other - BY_M


class _Readings(NamedTuple):
    """Readings of the scans of all stretches; for each, first the scans without motion, then those with it."""

    scans: NDArray[np.int64]  #: (n,)
    beams: NDArray[np.int64]  #: (b,)
    angles: Float64Array  #: (b,), radians
    mounts: Float64Array  #: (3,) or (n, 1, 3)
    ranges: Float64Array  #: (n, b), metres, 0 where not measured
    measured: NDArray[np.bool_]  #: (n, b)
    splits: NDArray[np.int64]  #: index of the first measured reading of each group of scans except the first


class Agreement:
    """Scans of a log with robot motion, compared with others, a moment apart, with hardly any.

    ``span_s`` seconds after its stamp is the time span of the motion in a scan. Poses are those of a trajectory, None
    for the default. ``tells`` is False if the motion is too small.
    """

    def __init__(self, log: ScanLog, span_s: float, trajectory: str | None = None) -> None:
        self._log, self._motion, self._first = log, Motion.of(log, trajectory), seconds(log)
        begin, end = self._motion.at(self._first), self._motion.at(self._first + span_s)
        turned = np.abs(np.angle(np.exp(1j * (end[:, 2] - begin[:, 2]))))
        moved = np.hypot(*(end - begin)[:, :2].T) + REACH_M * turned
        usable = self._motion.is_dense(self._first, self._first + span_s)
        self._stretches = max((_stretches(moved, usable, length) for length in (STRETCH, SHORTER)), key=len)
        self.tells = len(self._stretches) >= LEAST_STRETCHES
        #: Time of each stretch, seconds.
        self.times = np.array([float(self._first[np.concatenate(scans)].mean()) for scans in self._stretches])
        self._seen: dict[int, _Readings] = {}  #: by the maximum number of beams per scan

    def apart(self, increment: float, delays: float | Float64Array = 0.0, most_beams: int = MOST_BEAMS) -> float:
        """Return the mean distance, metres, of endpoints in moving scans from the nearest endpoint in the others.

        Beams are measured ``increment`` seconds apart, the first of them ``delays`` after the stamp, one value for all
        or (stretches,).
        """
        distances, counts = self.by_stretch(increment, delays, most_beams)
        return float(distances.sum() / counts.sum()) if counts.any() else 0.0

    def by_stretch(
        self, increment: float, delays: float | Float64Array, most_beams: int = MOST_BEAMS
    ) -> tuple[Float64Array, Float64Array]:
        """Return the sum of the distances of :meth:`apart` in each stretch (stretches,), metres, and their number."""
        from scipy.spatial import cKDTree  # noqa: PLC0415 - SciPy, which few logs need

        sums, counts = np.zeros(len(self._stretches)), np.zeros(len(self._stretches))
        if not self._stretches:
            return sums, counts
        ends = self._ends(increment, np.broadcast_to(np.asarray(delays, dtype=np.float64), sums.shape), most_beams)
        for number, (others, moving) in enumerate(zip(ends[::2], ends[1::2], strict=True)):
            if len(others):
                nearest = cKDTree(others).query(moving, distance_upper_bound=FARTHEST_M)[0]
                sums[number], counts[number] = np.minimum(nearest, FARTHEST_M).sum(), len(nearest)
        return sums, counts

    def best(self, increment: float, first_beam: float = 0.0) -> tuple[float, float]:
        """Return the minimum distance over all delays, and that delay, seconds.

        Without delay, the first beam is measured ``first_beam`` seconds after the stamp.
        """

        def tried(delays: Iterable[float], most_beams: int = MOST_BEAMS) -> list[tuple[float, float]]:
            return [(self.apart(increment, first_beam + delay, most_beams), delay) for delay in delays]

        _, delay = min(tried(DELAYS_S, FEWER_BEAMS))
        ((least, delay),) = tried([delay])
        for step in FINER_S:
            least, delay = min((least, delay), *tried((delay - step, delay + step)))
        return least, delay

    def _ends(self, increment: float, delays: Float64Array, most_beams: int) -> list[Float64Array]:
        """Return the endpoints (n, 2) of beams: for each stretch those of the scans without motion, then with it.

        ``delays`` (stretches,) are seconds. All stretches are computed at once, because they are many small arrays.
        """
        seen = self._readings(most_beams)
        first = self._first[seen.scans] + np.repeat(delays, [len(still) + len(fast) for still, fast in self._stretches])
        if increment == 0.0:
            bases = self._motion.at(first)[:, np.newaxis]
        else:
            bases = self._motion.along(first[:, np.newaxis] + increment * seen.beams)
        sensors = compose(bases, seen.mounts)
        headings = sensors[..., 2] + seen.angles
        directions = np.stack([np.cos(headings), np.sin(headings)], axis=-1)
        ends = sensors[..., :2] + seen.ranges[..., np.newaxis] * directions
        return np.split(ends[seen.measured], seen.splits)

    def _readings(self, most_beams: int) -> _Readings:
        """Return the readings of the stretches, computed once."""
        if most_beams not in self._seen:
            log = self._log
            groups = [scans for stretch in self._stretches for scans in stretch]
            scans = np.concatenate(groups)
            beams = np.arange(0, log.n_beams, 1 + log.n_beams // most_beams)
            mounts = log.mounts_at(scans)
            ranges = log.ranges[np.ix_(scans, beams)].astype(np.float64)
            with np.errstate(invalid="ignore"):
                measured = (ranges > max(log.range_min, 0.0)) & (ranges < log.range_max)
            last_rows = np.cumsum([len(group) for group in groups]) - 1
            self._seen[most_beams] = _Readings(
                scans,
                beams,
                log.angles[beams],
                mounts if mounts.ndim == 1 else mounts[:, np.newaxis],
                np.where(measured, ranges, 0.0),
                measured,
                np.cumsum(measured.sum(axis=1))[last_rows[:-1]],
            )
        return self._seen[most_beams]


def _stretches(
    moved: Float64Array, usable: NDArray[np.bool_], length: int
) -> list[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Return the scans with hardly any motion, and those with motion, of some stretches of a log.

    Each stretch has ``length`` scans; ``moved`` (n,) is the motion of a beam's end within the span of each scan,
    metres.
    """
    stretches = []
    for start in range(0, len(moved), length):
        scans = start + np.flatnonzero(usable[start : start + length])
        scans = scans[np.argsort(moved[scans], kind="stable")]
        fast, rest = scans[-FAST:], scans[:-FAST]
        usual = float(np.median(moved[fast])) if len(fast) else 0.0
        still = rest[moved[rest] <= STILL * usual]
        if usual >= LEAST_MOVED_M and len(still) >= LEAST_STILL:
            still = still[np.linspace(0, len(still) - 1, min(len(still), MOST_STILL)).astype(np.int64)]
            stretches.append((usual, still, fast))
    best = sorted(stretches, key=lambda candidate: -candidate[0])[:MOST_STRETCHES]
    return [(still, fast) for _, still, fast in best]
