"""Whether the readings of a log contradict the times at which its beams were measured, by what its messages state.

Simulators and drivers state a ``time_increment`` of scans that were measured at once, or in another order. Where the
robot turns, beams that are placed by it end beside the walls that others saw where it hardly moved. It is asked when a
log is read, so that the map is right by itself; the doctor asks more thoroughly (:mod:`mapper.diagnosis.sweep`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import compose
from mapper.sensors.motion import Motion, seconds
from mapper.sensors.scan import ScanLog

Float64Array = NDArray[np.float64]

STRETCH = 40  #: scans one after another that are compared with each other: poses drift little meanwhile
MOST_STRETCHES = 10  #: that are looked at, those in which the robot moves most
FAST, LEAST_STILL, MOST_STILL = 5, 4, 10  #: scans of each in which it moves most, and hardly
LEAST_STRETCHES = 2  #: fewer tell nothing
MOST_BEAMS = 360  #: of each scan
REACH_M = 3.0  #: a turn of 1 rad moves the end of a beam so far
LEAST_MOVED_M = 0.05  #: by which the robot moves a beam's end within a sweep, where this tells anything
STILL = 0.5  #: of that, at most, where it hardly moves
FARTHEST_M = 0.3  #: from the nearest end of another beam: what is farther was not seen by others
BETTER, BY_M = 0.75, 0.01  #: the share, and by how much, that beams taken at once end nearer to others
DELAYS_S = tuple(0.05 * k for k in range(-6, 7))  #: of the scans, with which an order of beams may fit best
FINER_S = (0.025, 0.0125, 0.00625)  #: steps by which it is looked for around the best of them


@dataclass(frozen=True, slots=True)
class Sweep:
    """When the beams of a scan were measured, as the readings say: at once, or ``reversed``; ``why`` is a sentence."""

    why: str
    reversed: bool


def contradicted_sweep(log: ScanLog) -> Sweep | None:
    """Return how the beams of a scan were measured in place of the stated times; None where that is not clear.

    Poses are those of the log's first trajectory. Each order is taken with the delay with which it fits best, so that
    late poses do not decide, and the stated one must fit clearly worse.
    """
    if not log.can_deskew():
        return None
    motion, first = Motion.of(log), seconds(log)
    sweep = log.time_increment * (log.n_beams - 1)
    begin, end = motion.at(first), motion.at(first + sweep)
    turned = np.abs(np.angle(np.exp(1j * (end[:, 2] - begin[:, 2]))))
    moved = np.hypot(*(end - begin)[:, :2].T) + REACH_M * turned
    stretches = _stretches(moved, motion.is_dense(first, first + sweep))
    if len(stretches) < LEAST_STRETCHES:
        return None
    from scipy.spatial import cKDTree  # noqa: PLC0415 - SciPy, which few logs need

    def apart(increment: float, delay: float) -> float:
        """Return how far ends in the scans with motion are from the nearest in the others, on average, metres."""
        found = [np.zeros(0)]
        for scans in stretches:
            others, ends = (_ends(log, motion, first[some] + delay, some, increment) for some in scans)
            if len(others):
                found.append(cKDTree(others).query(ends, distance_upper_bound=FARTHEST_M)[0])
        distances = np.minimum(np.concatenate(found), FARTHEST_M)
        return float(distances.mean()) if len(distances) else 0.0

    def best(increment: float, first_beam: float) -> float:
        """Return the least distance with any delay, where the first beam is measured so long after the stamp."""
        least, delay = min((apart(increment, first_beam + delay), delay) for delay in DELAYS_S)
        for step in FINER_S:
            least, delay = min(
                (least, delay), *((apart(increment, first_beam + d), d) for d in (delay - step, delay + step))
            )
        return least

    def fits(one: float, other: float) -> bool:
        return one <= BETTER * other and one <= other - BY_M

    if apart(log.time_increment, 0.0) <= BY_M:  # nothing fits clearly better
        return None
    stated, at_once = best(log.time_increment, 0.0), best(0.0, 0.0)
    backwards = best(-log.time_increment, sweep)
    if not fits(min(at_once, backwards), stated):
        return None
    lasts = f"A sweep of {log.n_beams} beams takes {abs(sweep):.3g} s by the stated time_increment, and their readings"
    where = "so alone they end, where the robot turns, on walls that others saw."
    if fits(backwards, at_once):
        begins = "last" if sweep > 0.0 else "first"
        why = (
            f"{lasts} fit together as measured in the other order, the {begins} beam first: {where} They are taken so."
        )
        return Sweep(why, reversed=True)
    return Sweep(
        f"{lasts} fit together as measured at once: {where} The time_increment is not used (deskew off).",
        reversed=False,
    )


def _stretches(moved: Float64Array, usable: NDArray[np.bool_]) -> list[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Return the scans in which the robot hardly moves, and those in which it does, of some stretches of a log.

    ``moved`` (n,) is by how much it moves the end of a beam within the sweep of each scan, metres.
    """
    found = []
    for start in range(0, len(moved), STRETCH):
        scans = start + np.flatnonzero(usable[start : start + STRETCH])
        scans = scans[np.argsort(moved[scans], kind="stable")]
        fast, rest = scans[-FAST:], scans[:-FAST]
        usual = float(np.median(moved[fast])) if len(fast) else 0.0
        still = rest[moved[rest] <= STILL * usual]
        if usual >= LEAST_MOVED_M and len(still) >= LEAST_STILL:
            still = still[np.linspace(0, len(still) - 1, min(len(still), MOST_STILL)).astype(np.int64)]
            found.append((usual, still, fast))
    best = sorted(found, key=lambda one: -one[0])[:MOST_STRETCHES]
    return [(still, fast) for _, still, fast in best]


def _ends(
    log: ScanLog, motion: Motion, times: Float64Array, scans: NDArray[np.int64], increment: float
) -> Float64Array:
    """Return where beams of some scans end, (n, 2), each measured ``increment`` seconds after the one before it."""
    beams = np.arange(0, log.n_beams, 1 + log.n_beams // MOST_BEAMS)
    bases = motion.at(times[:, np.newaxis] + increment * beams)
    mounts = log.mounts_at(scans)
    sensors = compose(bases, mounts if mounts.ndim == 1 else mounts[:, np.newaxis])
    ranges = log.ranges[np.ix_(scans, beams)].astype(np.float64)
    with np.errstate(invalid="ignore"):
        measured = (ranges > max(log.range_min, 0.0)) & (ranges < log.range_max)
    headings = sensors[..., 2] + log.angles[beams]
    ranges = np.where(measured, ranges, 0.0)
    ends = sensors[..., :2] + ranges[..., np.newaxis] * np.stack([np.cos(headings), np.sin(headings)], axis=-1)
    return np.asarray(ends[measured])
