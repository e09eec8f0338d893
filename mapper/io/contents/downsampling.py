"""Fewer points of a series for a plot that looks the same: the least and the greatest value of each bucket of time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def min_max(
    stamps_ns: NDArray[np.int64], values: NDArray[np.float32], buckets: int
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return at most ``2 · buckets`` rows of a series: per bucket of equal time and per column its extreme values.

    ``stamps_ns`` (n,) ascending, ``values`` (n, columns). Of each bucket that holds a sample there are two rows, at the
    times of its first and of its last sample: the least and the greatest value of each column, in the order in which
    they come in that column. NaN only where a bucket holds nothing else. A series that is short enough is returned as
    it is. No extreme of the series is lost, unlike with every n-th sample.
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
    is_empty = low > high  # of a column that is NaN throughout the bucket
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
