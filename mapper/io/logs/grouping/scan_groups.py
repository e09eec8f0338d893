"""Grouping of one sensor's scans by equal beams and limits, so that each message is interpreted by its own values.

A lidar that is switched to another resolution or range, or whose driver changes its limits occasionally, has a few
groups. Limits that change with every message are applied to that message's readings; angles that change with every
message are resampled onto the most common beams.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Int64Array
from mapper.core.errors import LimitError
from mapper.core.limits import Limits
from mapper.core.se2 import wrap_angle
from mapper.io.logs.grouping.stated_scans import Beaming, StatedScans, median_seconds
from mapper.sensors.scan import MAX_STATED_S

#: Interpretation of implausible limits → the sentence on them. Source: sensor_msgs/LaserScan and Range; REP 117, whose
#: fixed-distance rangers state both limits as one distance.
UNLIMITED, INFINITE, SWAPPED, FIXED = "unlimited", "infinite", "swapped", "fixed"
_SENTENCES = {
    UNLIMITED: (
        "state a range_max of {range_max:g} m, which no sensor has: readings of any distance count, and the map’s max "
        "range limits them."
    ),
    INFINITE: (
        "state no maximum range (range_max inf): readings of any distance count, and the map’s max range limits them."
    ),
    SWAPPED: (
        "state a range_min of {range_min:g} m above their range_max of {range_max:g} m: the two are taken the other "
        "way round."
    ),
    FIXED: (
        "state {range_max:g} m as range_min and range_max: they are of a ranger for one fixed distance (REP 117), "
        "whose −inf says that something is nearer and +inf that nothing is. No distance is measured, so it draws no "
        "walls; with no_return free what is +inf clears the cells up to there."
    ),
}


def usable_limits(range_min: float, range_max: float) -> tuple[float, float, str]:
    """Return the minimum and maximum valid distance, metres, and how they were interpreted, "" if as stated.

    The maximum is inf if no valid one is stated.
    """
    least = range_min if 0.0 <= range_min < math.inf else 0.0
    if not range_max > 0.0:  # also NaN
        return least, math.inf, UNLIMITED
    if range_max == math.inf:
        return least, math.inf, INFINITE
    if least > range_max:
        return range_max, least, SWAPPED
    if least == range_max:
        return 0.0, range_max, FIXED
    return least, range_max, ""


def notes_on_limits(where: str, n_scans: int, stated: Mapping[tuple[float, float], int]) -> list[str]:
    """Return a note for each kind of implausible limits.

    ``stated`` has the pairs range_min, range_max of the messages described by ``where``, and how many of the
    ``n_scans`` messages state each.
    """
    counts: Counter[str] = Counter()
    examples: dict[str, tuple[float, float]] = {}
    for pair, count in stated.items():
        how = usable_limits(*pair)[2]
        if how:
            counts[how] += count
            examples.setdefault(how, pair)
    return [
        f"{counted(counts[how], n_scans)} {where} "
        + _SENTENCES[how].format(range_min=examples[how][0], range_max=examples[how][1])
        for how in counts
    ]


def counted(some: int, of: int) -> str:
    """Return the number of a topic's messages, as the beginning of a sentence."""
    return f"All {of} messages" if some == of else f"{some} of the {of} messages"


MOST_GROUPS = 64  #: of one sensor
MOST_COMPARED = 100  #: distinct angles of one sensor
MOST_TOLD = 4  #: groups described by a note
MOST_STEPS = 4  #: distinct times between beams
SAME_ANGLE = 2e-5  #: radians: tolerance of 32-bit angles
STEP_APART = 1.25  #: times between beams that differ by this factor are in different groups
LIMIT_FOLLOWS = 0.9  #: fraction of scans whose largest reading is their range_max, above which it is not a limit
CODE_SHARE = 0.002  #: of the readings: if more are exactly range_max, that is a code
CODE_LEAST = 20  #: minimum number of readings equal to a code
NOISE_BAND = 0.05  #: of range_max: readings this near to it may be a noisy code
MOST_NOISE = 5.0  #: standard deviations
HALF_NORMAL_QUARTILE = 0.3186  #: quartile of the half-normal distribution, standard deviations
NOISE_HALVES = 1.5  #: maximum ratio of the numbers of readings on the two sides of range_max
NOISE_WALLS = 0.1  #: maximum fraction of the readings just below the noise band


@dataclass(frozen=True, slots=True)
class ScanGroup:
    """Scans with equal beams: ``scans`` (n,) are their indices, ``ranges`` (n, n_beams) float32 their readings.

    Angles are radians in the sensor's frame, limits metres, ``time_increment`` seconds between beams.
    """

    scans: Int64Array
    ranges: NDArray[np.float32]
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    time_increment: float


def scan_groups(sensor: StatedScans, limits: Limits) -> tuple[list[ScanGroup], list[str]]:
    """Return the groups of a sensor's scans, the largest first, and notes on them.

    Raises :class:`LimitError` for too many readings.
    """
    return _Grouping(sensor, limits).groups()


class _Grouping:
    def __init__(self, sensor: StatedScans, limits: Limits) -> None:
        self.sensor, self.limits = sensor, limits
        self.beamings, self.of_scan = sensor.beamings, sensor.beaming_of_scan
        counts = np.bincount(self.of_scan, minlength=len(self.beamings)).tolist()
        self.usable = [usable_limits(beaming.range_min, beaming.range_max)[:2] for beaming in self.beamings]
        self.angles = _same_angles(self.beamings)
        self.notes: list[str] = []
        stated: Counter[tuple[float, float]] = Counter()
        for beaming_, count in zip(self.beamings, counts, strict=True):
            stated[beaming_.range_min, beaming_.range_max] += count
        if not sensor.is_cut:
            self.notes += notes_on_limits(sensor.where, sensor.n_scans, stated)

    def groups(self) -> tuple[list[ScanGroup], list[str]]:
        ranges = self._padded()
        largest = np.array([limit[1] for limit in self.usable])[self.of_scan]
        steps = _steps(self.sensor.time_increments)
        angles = np.array(self.angles)[self.of_scan]
        limits = _numbered(self.usable)[self.of_scan]
        if self._limits_follow_readings(ranges, largest):
            limits = np.zeros_like(limits)
        else:
            ranges = self._without_codes(ranges, largest)
        keys = np.column_stack([angles, limits, steps])
        if len(np.unique(keys, axis=0)) > MOST_GROUPS and np.ptp(steps):
            keys[:, 2] = 0
            self.notes.append(
                f"time_increment {self.sensor.where} changes with the messages, and their beams or limits do so in "
                f"more ways than {MOST_GROUPS}: the median of all, {median_seconds(self.sensor.time_increments):.3g} "
                "s, is used."
            )
        if len(np.unique(keys, axis=0)) > MOST_GROUPS and np.ptp(limits):
            ranges = self._within_own_limits(ranges, largest)
            keys[:, 1] = 0
        if len(np.unique(keys, axis=0)) > MOST_GROUPS:
            ranges = self._on_usual_beams(ranges)
            keys[:, 0] = 0
        _, group_of_scan = np.unique(keys, axis=0, return_inverse=True)
        group_of_scan = group_of_scan.reshape(-1)
        counts = np.bincount(group_of_scan)
        groups = [self._group(np.flatnonzero(group_of_scan == k), ranges) for k in np.argsort(-counts, kind="stable")]
        if len(groups) > 1:
            self.notes.append(self._note_on_groups(groups))
        return groups, self.notes

    def _padded(self) -> NDArray[np.float32]:
        """Return all readings (n_scans, most beams), padded with NaN."""
        flat = self.sensor.readings
        counts = np.array([beaming.beams for beaming in self.beamings], dtype=np.int64)
        n, most = self.sensor.n_scans, int(counts.max())
        if (counts == most).all():
            return flat.reshape(n, most)
        if n * most > self.limits.max_readings:
            raise LimitError(
                "log.too_many_scans",
                f"{n} scans of {most} beams {self.sensor.where} are more than {self.limits.max_readings} readings.",
            )
        out = np.full((n, most), np.nan, dtype=np.float32)
        out[np.arange(most) < counts[self.of_scan][:, np.newaxis]] = flat
        return out

    def _group(self, scans: Int64Array, ranges: NDArray[np.float32]) -> ScanGroup:
        own = Counter(self.of_scan[scans].tolist())
        usual = self.beamings[max(own, key=lambda k: own[k])]
        beams = max(self.beamings[k].beams for k in own) if len(set(np.array(self.angles)[list(own)])) == 1 else 0
        readings = ranges[scans] if len(scans) < len(ranges) else ranges
        return ScanGroup(
            scans,
            readings[:, : beams or usual.beams],
            usual.angle_min,
            usual.angle_increment,
            min(self.usable[k][0] for k in own),
            max(self.usable[k][1] for k in own),
            median_seconds(self.sensor.time_increments[scans]),
        )

    def _limits_follow_readings(self, ranges: NDArray[np.float32], largest: NDArray[np.float64]) -> bool:
        """Return whether range_max is the largest reading of each message, and therefore not a limit of the sensor."""
        if len(np.unique(largest)) < 3 or ranges.shape[1] < 2:
            return False
        farthest = np.where(np.isfinite(ranges), ranges, -np.inf).max(axis=1)
        some = np.isfinite(farthest)
        if not some.any() or np.mean(farthest[some] == largest[some]) < LIMIT_FOLLOWS:
            return False
        self.notes.append(
            f"range_max {self.sensor.where} is the largest reading of each message, {largest.min():.2f} to "
            f"{largest.max():.2f} m, not the sensor’s limit: every reading counts in the message that holds it."
        )
        return True

    def _without_codes(self, ranges: NDArray[np.float32], largest: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the readings with those equal to range_max replaced by +inf, if they are many.

        If noise was added to them, as simulators do, those just below it are also no returns.
        """
        limits = largest[:, np.newaxis].astype(np.float32)
        is_code = np.isfinite(ranges) & (ranges == limits)
        noise = _noise_below(ranges, limits)
        if noise:
            is_code |= np.isfinite(ranges) & (ranges > limits - noise)
        n = int(np.count_nonzero(is_code))
        measured = int(np.count_nonzero(np.isfinite(ranges)))
        scans = int(np.count_nonzero(is_code.any(axis=1)))
        if n < max(CODE_LEAST, CODE_SHARE * measured) or (n < 2 * scans and ranges.shape[1] > 1):
            return ranges
        limit = largest[np.argmax(is_code.any(axis=1))]
        at = (
            f"at range_max, {limit:g} m, with noise of some {noise / MOST_NOISE:.2g} m"
            if noise
            else f"exactly range_max, {limit:g} m"
        )
        self.notes.append(
            f"{n} readings {self.sensor.where} ({100.0 * n / measured:.1f} %) are {at}: simulators and some drivers "
            "say no return so. They are taken for no return, not for walls at that distance."
        )
        return np.where(is_code, np.float32(np.inf), ranges)

    def _within_own_limits(self, ranges: NDArray[np.float32], largest: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the readings within the limits of their own message.

        Farther readings are no returns, which are dropped from scans with a smaller limit than others, because one
        number for all cannot describe up to which distance they clear cells.
        """
        least = np.array([limit[0] for limit in self.usable])[self.of_scan]
        with np.errstate(invalid="ignore"):
            out = np.where(ranges < least[:, np.newaxis], np.float32(-np.inf), ranges)
            out = np.where(ranges > largest[:, np.newaxis], np.float32(np.inf), out)
            nearer = (largest < largest.max())[:, np.newaxis] & (out == np.inf)
        lost = int(np.count_nonzero(nearer))
        note = (
            f" Of {lost} readings without a return in messages with a smaller range_max than {largest.max():.2f} m, "
            "no_return free clears nothing."
        )
        self.notes.append(
            f"range_min or range_max {self.sensor.where} change with the messages in more than {MOST_GROUPS} ways "
            f"(range_max {largest.min():.2f} to {largest.max():.2f} m): each message’s readings count within its own "
            f"limits.{note if lost else ''}"
        )
        return np.where(nearer, np.float32(np.nan), out)

    def _on_usual_beams(self, ranges: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the readings (n_scans, n_beams) on the most common beams, each assigned to the nearest."""
        usual = self.sensor.usual
        out = np.full((len(ranges), usual.beams), np.nan, dtype=np.float32)
        own = self.angles[self.beamings.index(usual)]
        others = 0
        order = np.argsort(self.of_scan, kind="stable")
        edges = np.searchsorted(self.of_scan[order], np.arange(1, len(self.beamings)))
        for number, (beaming, scans) in enumerate(zip(self.beamings, np.split(order, edges), strict=True)):
            if self.angles[number] == own:
                same = min(usual.beams, beaming.beams)
                out[scans, :same] = ranges[scans, :same]
                continue
            others += len(scans)
            to, taken = _nearest(beaming, usual)
            out[np.ix_(scans, to)] = ranges[np.ix_(scans, taken)]
        self.notes.append(
            f"{others} of the {len(ranges)} scans {self.sensor.where} have other beams than the rest, in more than "
            f"{MOST_GROUPS} ways: their readings count at the nearest of the usual beams, "
            f"{np.degrees(abs(usual.angle_increment)):.2g}° apart."
        )
        return out

    def _note_on_groups(self, groups: list[ScanGroup]) -> str:
        kinds = [
            f"{len(group.scans)} with {group.ranges.shape[1]} beams {np.degrees(group.angle_increment):.4g}° apart "
            f"from {np.degrees(group.angle_min):.4g}°, up to {group.range_max:g} m"
            for group in groups[:MOST_TOLD]
        ]
        more = f"; and {len(groups) - MOST_TOLD} kinds more" if len(groups) > MOST_TOLD else ""
        return (
            f"{counted(self.sensor.n_scans, self.sensor.n_scans)} {self.sensor.where} do not have the same beams or "
            f"limits: {'; '.join(kinds)}{more}. Each scan is read as it states itself."
        )


def _same_angles(beamings: list[Beaming]) -> list[int]:
    """Return for each beaming the index of its angles, which are compared modulo one turn."""
    known = np.empty((0, 2))
    equal = []
    for number, beaming in enumerate(beamings):
        off = np.abs(wrap_angle(known[:, 0] - beaming.angle_min))
        off = np.maximum(
            off, np.abs(known[:, 1] - beaming.angle_increment) * (0.05 * beaming.beams if beaming.beams > 1 else 0.0)
        )
        same = np.flatnonzero(off < SAME_ANGLE)
        if len(same):
            equal.append(int(same[0]))
        elif len(known) < MOST_COMPARED:
            equal.append(len(known))
            known = np.vstack([known, [beaming.angle_min, beaming.angle_increment]])
        else:
            equal.append(MOST_COMPARED + number)  # this one is resampled onto the usual beams anyway
    return equal


def _noise_below(ranges: NDArray[np.float32], limits: NDArray[np.float32]) -> float:
    """Return how far below their limits (n_scans, 1) noise shifts no-return readings; 0 if there is no noise.

    With Gaussian noise one half of the readings is below the limit, and the other half above it, or at it if clipped.
    There are hardly any below five standard deviations, unless they are walls.
    """
    with np.errstate(invalid="ignore"):
        is_near = ranges > (1.0 - NOISE_BAND) * limits
        is_near &= ranges < (1.0 + NOISE_BAND) * limits
    off = limits[np.nonzero(is_near)[0], 0] - ranges[is_near]
    off = off[np.isfinite(off)]
    below = off[off > 0.0]
    beyond = len(off) - len(below)
    if min(beyond, len(below)) < max(CODE_LEAST, CODE_SHARE * ranges.size):
        return 0.0
    noise = MOST_NOISE * float(np.quantile(below, 0.25)) / HALF_NORMAL_QUARTILE
    near, far = (int(np.count_nonzero((below > a * noise) & (below <= (a + 1) * noise))) for a in (0, 1))
    if 2.0 * noise > NOISE_BAND * float(limits.min()):  # ordinary walls around range_max
        return 0.0
    is_half = beyond <= NOISE_HALVES * near and near <= NOISE_HALVES * beyond
    return noise if is_half and far <= NOISE_WALLS * near else 0.0


def _steps(stated: NDArray[np.float32]) -> Int64Array:
    """Return indices (n_scans,) that differ if the times between beams do, as for a lidar with a switched rate.

    Zero for all if they vary continuously.
    """
    usable = np.where(np.abs(stated) <= MAX_STATED_S, np.abs(stated), 0.0)
    sorted_steps = np.unique(usable)
    edges = sorted_steps[1:] > STEP_APART * sorted_steps[:-1]
    if np.count_nonzero(edges) >= MOST_STEPS:
        return np.zeros(len(stated), dtype=np.int64)
    number = np.concatenate([[0], np.cumsum(edges)])
    return np.asarray(number[np.searchsorted(sorted_steps, usable)], dtype=np.int64)


def _numbered(pairs: list[tuple[float, float]]) -> Int64Array:
    known = {pair: number for number, pair in enumerate(dict.fromkeys(pairs))}
    return np.array([known[pair] for pair in pairs], dtype=np.int64)


def _nearest(theirs: Beaming, usual: Beaming) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return which of the usual beams have one of theirs within half a step, and which one."""
    angles = usual.angle_min + usual.angle_increment * np.arange(usual.beams)
    if theirs.angle_increment == 0.0:
        index = np.zeros(usual.beams)
    else:
        turn = abs(2.0 * np.pi / theirs.angle_increment)
        index = np.clip(np.rint((angles - theirs.angle_min) / theirs.angle_increment % turn), 0, theirs.beams - 1)
    away = np.abs(wrap_angle(theirs.angle_min + theirs.angle_increment * index - angles))
    from_first = np.abs(wrap_angle(theirs.angle_min - angles))  # nearer if it is one turn before their last
    index, away = np.where(from_first < away, 0, index), np.minimum(from_first, away)
    near = away <= max(abs(usual.angle_increment), abs(theirs.angle_increment)) / 2.0 + 1e-9
    return np.nonzero(near)[0], index[near].astype(np.intp)
