"""Pairs of poses some distance, time or number of poses apart, for relative errors.

Source: evo's ``filters.py``; pairs by time are formed like those by distance, with the elapsed time (the TUM RGB-D
benchmark's ``evaluate_rpe.py`` also pairs by seconds).
"""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.errors import ConfigError

DELTA_UNITS = ("m", "s", "frames")
TOLERANCE = 0.1  #: of the distance, for all pairs, as in evo


def pairs_over(
    delta: float,
    unit: str,
    poses: Float64Array,
    stamps_ns: Int64Array,
    *,
    all_pairs: bool = False,
    tolerance: float = TOLERANCE,
) -> Int64Array:
    """Return pairs (k, 2) of indices of ``poses`` (n, 3), ``delta`` apart along the path.

    ``unit`` is "m", the distance travelled in metres, "s", seconds of ``stamps_ns`` (n,), or "frames", poses. Pairs are
    consecutive: each ends at the first pose that is at least ``delta`` farther, where the next begins. With
    ``all_pairs`` each pose begins one, which ends at the pose whose distance is nearest to ``delta``, if it differs by
    at most ``tolerance`` · ``delta``; of poses at the same distance, as for a robot at rest, it is the first. Raises
    :class:`ConfigError` for another unit, a delta that is not positive or not an integer number of frames, for seconds
    along stamps that run backwards, and if there are no such pairs.
    """
    if unit not in DELTA_UNITS:
        raise ConfigError("evaluation.delta_unit", f"The unit of delta must be m, s or frames, not {unit!r:.40}.")
    if not (np.isfinite(delta) and delta > 0.0) or (unit == "frames" and delta != round(delta)):
        expected = "a whole number of frames above 0" if unit == "frames" else "above 0"
        raise ConfigError("evaluation.delta", f"Delta must be {expected}, not {delta:g}.")
    if unit == "frames":
        pairs = _by_frames(len(poses), int(delta), all_pairs=all_pairs)
    else:
        steps = _steps_s(stamps_ns) if unit == "s" else np.hypot(*np.diff(poses[:, :2], axis=0).T)
        pairs = _all_pairs(steps, delta, tolerance * delta) if all_pairs else _consecutive(steps, delta)
    if not len(pairs):
        raise ConfigError("evaluation.no_delta", f"No two poses are {delta:g} {unit} apart: take a smaller delta.")
    return pairs


def _by_frames(n: int, delta: int, *, all_pairs: bool) -> Int64Array:
    begin = np.arange(0, max(0, n - delta), 1 if all_pairs else delta, dtype=np.int64)
    return np.column_stack([begin, begin + delta])


def _steps_s(stamps_ns: Int64Array) -> Float64Array:
    steps = np.diff(stamps_ns)
    if (steps < 0).any():
        raise ConfigError(
            "evaluation.backwards",
            "Poses cannot be paired by seconds, since their stamps run backwards: use metres or frames.",
        )
    return steps / 1e9


def _consecutive(steps: Float64Array, delta: float) -> Int64Array:
    ids, travelled = [0], 0.0
    for i, step in enumerate(steps.tolist(), start=1):
        travelled += step
        if travelled >= delta:
            ids.append(i)
            travelled = 0.0
    return np.column_stack([ids[:-1], ids[1:]]).astype(np.int64)


def _all_pairs(steps: Float64Array, delta: float, tolerance: float) -> Int64Array:
    travelled = np.concatenate([[0.0], np.cumsum(steps)])
    begin = np.arange(len(travelled) - 1)
    # The two poses around the target distance, each the first with its distance, but after the beginning.
    high = np.clip(np.searchsorted(travelled, travelled[:-1] + delta), begin + 1, len(travelled) - 1)
    low = np.maximum(np.searchsorted(travelled, travelled[np.maximum(high - 1, begin + 1)]), begin + 1)
    off_low, off_high = (
        np.abs(travelled[low] - travelled[:-1] - delta),
        np.abs(travelled[high] - travelled[:-1] - delta),
    )
    end = np.where(off_low <= off_high, low, high)
    near = np.minimum(off_low, off_high) <= tolerance
    return np.column_stack([begin[near], end[near]])
