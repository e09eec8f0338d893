"""Detection of sudden differences between the motions by scans and by wheels, as opposed to gradual ones.

The difference of the two motions is summed over windows of many lengths. Systematic wheel errors (scale, rotation,
mount offset) are removed by a linear fit. The rest is compared with the usual difference in windows of the same length
and motion in the same log, so that the threshold grows with the errors of the wheels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.diagnosis.events.motions import WITHIN, Loss, Motions

WINDOWS = (1, 2, 3, 5, 8, 12, 18, 27, 40, 60, 90)  #: steps
LONGEST_S = 10.0  #: of a window of several steps
LEAST_M, LEAST_RAD = 0.08, math.radians(5.0)  #: minimum size of an event; smaller ones do not matter for 5 cm cells
SHARE = 0.2  #: fraction of the smaller of the two motions in the window that is added to these
USUAL = 8.0  #: times the usual difference: wheel errors have longer tails than a normal distribution
NOISE_M, NOISE_RAD = 0.005, math.radians(0.3)  #: of an alignment, the minimum assumed wheel error
TURN_M = 0.3  #: metres of path per radian of turn
STILL_M = 0.1  #: metres of path added, so that noise counts when the robot is at rest
MOST_EVENTS = 50
ALONG = 0.4  #: fraction of the mean step of a displacement above which adjacent steps belong to it
STAYS = 0.5  #: fraction by which it may change in the surrounding window: an error of one scan is undone
AROUND_STEPS = 3
FIT_PASSES = 8
_LEVER = np.array([1.0, 1.0, LEAST_M / LEAST_RAD])


@dataclass(frozen=True, slots=True)
class Displacement:
    """A sudden difference between scans ``before`` and ``after`` (indices into the motions), with start and end in
    seconds.

    ``moved`` (3,) is the motion by the scans minus that by the wheels, in the robot's frame; ``by_wheels`` and
    ``by_scans`` (3,) are the two sums over the window. ``lost`` means that scans in between could not be aligned;
    ``moved`` may then be None.
    """

    before: int
    after: int
    begin_s: float
    end_s: float
    moved: Float64Array | None
    by_wheels: Float64Array
    by_scans: Float64Array
    lost: bool = False


def displacements(motions: Motions, untold: NDArray[np.bool_]) -> list[Displacement]:
    """Return the sudden differences in order, except those in steps that are ``untold`` (n - 1,)."""
    if len(motions.by_wheels) < 2 * AROUND_STEPS:
        return []
    rest = _without_systematic(compose(inverse(motions.by_wheels), motions.by_scans), motions)
    rest[untold] = 0.0
    for loss in motions.losses:  # adjacent differences belong to the loss
        rest[max(0, loss.before - WITHIN) : loss.after + WITHIN] = 0.0
    displaced = _windows(rest, motions)
    displaced += [displacement for loss in motions.losses if (displacement := _of_loss(loss, motions)) is not None]
    return sorted(displaced, key=lambda displacement: displacement.before)


def _without_systematic(differences: Float64Array, motions: Motions) -> Float64Array:
    """Return the differences (n, 3) minus their linear dependence on the wheels' motion, by least absolute deviations.

    Scale, rotation and mount errors depend on the motion, a delay between scans and wheels on its change. They are
    fitted by iteratively reweighted least squares with weights 1 / |residual| (Schlossmacher 1973).
    """
    wheels = motions.by_wheels
    around = np.concatenate([wheels[:1], wheels, wheels[-1:]])
    # The motion, to second order in its rotation, and its change.
    terms = np.concatenate([wheels, wheels * wheels[:, 2:], around[2:] - around[:-2]], axis=1)
    rest = differences.copy()
    for column, least in enumerate((NOISE_M, NOISE_M, NOISE_RAD)):
        fit = np.zeros(terms.shape[1])
        for _ in range(FIT_PASSES):
            weighted = terms / np.maximum(np.abs(differences[:, column] - terms @ fit), least)[:, np.newaxis]
            fit = np.linalg.solve(weighted.T @ terms + 1e-3 * np.eye(len(fit)), weighted.T @ differences[:, column])
        rest[:, column] = differences[:, column] - terms @ fit
    return rest


def _sums(values: Float64Array, length: int) -> Float64Array:
    """Return the sums of ``length`` consecutive values from each index on."""
    total = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
    return np.asarray(total[length:] - total[:-length])


def _ways(motion: Float64Array, length: int) -> tuple[Float64Array, Float64Array]:
    """Return the path length and the rotation in each window."""
    driven = np.hypot(motion[:, 0], motion[:, 1])
    return _sums(driven, length), _sums(np.abs(motion[:, 2]), length)


def _windows(rest: Float64Array, motions: Motions) -> list[Displacement]:
    """Return the displacements of windows, selected in order of clarity; overlapping windows are part of a selected
    one.
    """
    steps = np.diff(motions.seconds)
    usual_s = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0
    candidates: list[tuple[float, int, int]] = []
    for length in WINDOWS:
        if length > len(rest) // 4 or (length > 1 and length * usual_s > LONGEST_S):
            break
        excess = _excess(rest, motions, length)
        candidates += [(float(excess[i]), int(i), int(i) + length) for i in np.flatnonzero(excess > 1.0)]
    candidates.sort(key=lambda candidate: (-candidate[0], candidate[1], candidate[2]))
    is_used = np.zeros(len(rest), dtype=np.bool_)
    windows: list[Displacement] = []
    for _, first, stop in candidates:
        if is_used[first:stop].any():
            continue
        if not _stays(rest, first, stop):
            continue
        is_used[max(0, first - AROUND_STEPS) : stop + AROUND_STEPS] = True
        windows.append(_timed(rest, motions, first, stop))
        if len(windows) == MOST_EVENTS:
            break
    return windows


def _excess(rest: Float64Array, motions: Motions, length: int) -> Float64Array:
    """Return the ratio of the difference in each window to the threshold of an event."""
    sums = _sums(rest, length)
    (driven, turn), (scan_way, scan_turn) = _ways(motions.by_wheels, length), _ways(motions.by_scans, length)
    spread = np.sqrt(driven + TURN_M * turn + STILL_M)
    moving = driven + TURN_M * turn > 0.25 * np.quantile(driven + TURN_M * turn, 0.9)
    compared = moving if moving.any() else ~moving
    usual = 1.4826 * np.median(np.abs(sums[compared]) / spread[compared, np.newaxis], axis=0)
    noise = np.array([NOISE_M, NOISE_M, NOISE_RAD])
    scale = np.hypot(usual * spread[:, np.newaxis], noise)
    far = np.hypot(sums[:, 0], sums[:, 1])
    least = LEAST_M + SHARE * np.minimum(driven, scan_way)
    least_turn = LEAST_RAD + SHARE * np.minimum(turn, scan_turn)
    by_far = np.minimum(far / least, np.hypot(sums[:, 0] / scale[:, 0], sums[:, 1] / scale[:, 1]) / USUAL)
    by_turn = np.minimum(np.abs(sums[:, 2]) / least_turn, np.abs(sums[:, 2]) / scale[:, 2] / USUAL)
    return np.asarray(np.maximum(by_far, by_turn), dtype=np.float64)


def _stays(rest: Float64Array, first: int, stop: int) -> bool:
    """Return whether a displacement persists some steps later, and was absent some steps before."""
    around = rest[max(0, first - AROUND_STEPS) : stop + AROUND_STEPS].sum(axis=0)
    own = rest[first:stop].sum(axis=0)
    is_last = stop >= len(rest)
    return not is_last and bool(np.linalg.norm((around - own) * _LEVER) < STAYS * np.linalg.norm(own * _LEVER))


def _timed(rest: Float64Array, motions: Motions, first: int, stop: int) -> Displacement:
    """Return the displacement of a window including adjacent steps that belong to it, with start and end times."""
    own = rest[first:stop].sum(axis=0)
    along = (rest * _LEVER) @ (own * _LEVER / np.linalg.norm(own * _LEVER))
    least = ALONG * float(along[first:stop].mean())
    while first > 0 and along[first - 1] > least:
        first -= 1
    while stop < len(rest) and along[stop] > least:
        stop += 1
    part = np.flatnonzero(along[first:stop] > 0.25 * least)
    first, stop = first + int(part[0]), first + int(part[-1]) + 1
    begin = motions.seconds[first + 1] - _taken(along, motions, first, first + 1)
    end = motions.seconds[stop - 1] + _taken(along, motions, stop - 1, stop - 2)
    return Displacement(
        first, stop, begin, max(begin, end), rest[first:stop].sum(axis=0), motions.by_wheels[first:stop].sum(axis=0),
        motions.by_scans[first:stop].sum(axis=0),
    )  # fmt: skip


def _taken(along: Float64Array, motions: Motions, step: int, beside: int) -> float:
    """Return how many seconds of a step at the border of a displacement it took, at the speed of the adjacent step."""
    seconds = np.diff(motions.seconds)
    own = float(seconds[step])
    if not 0 <= beside < len(along) or seconds[beside] <= 0.0:
        return own
    speed = float(along[beside] / seconds[beside])
    return min(own, float(along[step]) / speed) if speed > 0.0 else own


def _of_loss(loss: Loss, motions: Motions) -> Displacement | None:
    """Return the displacement during a loss of alignment; None if the robot is where the wheels predict."""
    begin, end = motions.seconds[loss.before], motions.seconds[loss.after]
    steps = motions.by_wheels[loss.before : loss.after]
    wheels = np.zeros(3)
    for step in steps:
        wheels = compose(wheels, step)
    if loss.moved is None:
        return Displacement(loss.before, loss.after, begin, end, None, wheels, wheels, lost=True)
    off = compose(inverse(wheels), loss.moved)
    off[:2] = loss.moved[:2] - wheels[:2]  # in the robot's frame before the loss
    driven = min(float(np.hypot(steps[:, 0], steps[:, 1]).sum()), math.hypot(loss.moved[0], loss.moved[1]))
    turn = min(float(np.abs(steps[:, 2]).sum()), abs(float(loss.moved[2])))
    is_far = math.hypot(off[0], off[1]) > 2.0 * LEAST_M + SHARE * driven
    is_turned = abs(float(wrap_angle(off[2]))) > 2.0 * LEAST_RAD + SHARE * turn
    if not (is_far or is_turned):
        return None
    return Displacement(loss.before, loss.after, begin, end, off, wheels, loss.moved, lost=True)
