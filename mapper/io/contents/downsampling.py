"""Preparation of a number over time for plots: derivative, moving average, and downsampling."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array, Int64Array
from mapper.sensors.gaps import are_gaps

_RATES = {"": "1/s", "m/s": "m/s²", "rad/s": "rad/s²"}


def unit_of_rate(unit: str) -> str:
    """Return the unit of a number's change per second."""
    return _RATES.get(unit, f"{unit}/s")


def derivative(stamps_ns: Int64Array, values: Float64Array, *, is_angle: bool = False) -> Float64Array:
    """Return the change per second (n,) since the previous sample, NaN for the first.

    ``stamps_ns`` (n,) ascending, ``values`` (n,). NaN if the stamp equals the previous one, and after a gap. The change
    of an angle in rad is wrapped to -pi to pi.
    """
    out = np.full(len(values), np.nan)
    seconds = np.diff(stamps_ns).astype(np.float64) * 1e-9
    change = np.diff(values)
    if is_angle:
        change = _wrapped(change)
    is_known = (seconds > 0.0) & ~are_gaps(seconds)
    out[1:][is_known] = change[is_known] / seconds[is_known]
    return out


def moving_average(
    stamps_ns: Int64Array, values: Float64Array, window_s: float, *, is_angle: bool = False
) -> Float64Array:
    """Return the mean (n,) of the values within half of ``window_s`` seconds before and after each.

    ``stamps_ns`` (n,) ascending, ``values`` (n,); non-finite values are ignored. For angles in rad it is the circular
    mean.
    """
    if is_angle:
        sine = moving_average(stamps_ns, np.sin(values), window_s)
        return np.arctan2(sine, moving_average(stamps_ns, np.cos(values), window_s))
    is_known = np.isfinite(values)
    level = float(values[is_known].mean()) if is_known.any() else 0.0  # sums of small numbers are more accurate
    sums = np.concatenate([[0.0], np.cumsum(np.where(is_known, values - level, 0.0))])
    counts = np.concatenate([[0], np.cumsum(is_known)])
    half = round(0.5e9 * window_s)
    low = np.searchsorted(stamps_ns, stamps_ns - half, side="left")
    high = np.searchsorted(stamps_ns, stamps_ns + half, side="right")
    n = counts[high] - counts[low]
    with np.errstate(invalid="ignore"):
        means: Float64Array = level + (sums[high] - sums[low]) / np.where(n > 0, n, np.nan)
    return means


def _wrapped(angle: Float64Array) -> Float64Array:
    wrapped: Float64Array = np.remainder(angle + math.pi, 2.0 * math.pi) - math.pi
    return wrapped


def min_max(
    stamps_ns: NDArray[np.int64], values: NDArray[np.float32], buckets: int
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return at most ``2 · buckets`` rows of a series: the extremes per bucket of equal duration and per column.

    ``stamps_ns`` (n,) ascending, ``values`` (n, columns). Each non-empty bucket has two rows, at the times of its first
    and last sample: the minimum and maximum of each column, in the order in which they occur in that column. NaN only
    if a bucket has no other value. A series that is short enough is returned unchanged. Unlike every n-th sample, this
    preserves all extremes of the series.
    """
    n = len(stamps_ns)
    if n <= 2 * buckets:
        return stamps_ns, values
    span = float(stamps_ns[-1] - stamps_ns[0])
    into = (stamps_ns - stamps_ns[0]).astype(np.float64)
    bucket = np.minimum(into / span * buckets, buckets - 1).astype(np.int64) if span > 0.0 else np.zeros(n, np.int64)
    starts = np.concatenate([[0], np.flatnonzero(np.diff(bucket)) + 1])
    ends = np.append(starts[1:], n)
    low_filled = np.where(np.isnan(values), np.inf, values)
    high_filled = np.where(np.isnan(values), -np.inf, values)
    low = np.minimum.reduceat(low_filled, starts)
    high = np.maximum.reduceat(high_filled, starts)
    is_empty = low > high  # for a column that is NaN in the whole bucket
    of_row = np.repeat(np.arange(len(starts)), ends - starts)
    rows = np.arange(n)[:, None]
    first_low = np.minimum.reduceat(np.where(low_filled == low[of_row], rows, n), starts)
    first_high = np.minimum.reduceat(np.where(high_filled == high[of_row], rows, n), starts)
    rises = first_low <= first_high
    out = np.empty((2 * len(starts), values.shape[1]), dtype=values.dtype)
    out[0::2] = np.where(is_empty, np.nan, np.where(rises, low, high))
    out[1::2] = np.where(is_empty, np.nan, np.where(rises, high, low))
    times = np.empty(2 * len(starts), dtype=np.int64)
    times[0::2] = stamps_ns[starts]
    times[1::2] = stamps_ns[ends - 1]
    return times, out
