"""What is made of a number over time before it is plotted: its derivative, or its moving average."""

from __future__ import annotations

import math

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.sensors.gaps import are_gaps


def derivative(stamps_ns: Int64Array, values: Float64Array, *, is_angle: bool = False) -> Float64Array:
    """Return the change per second (n,) since the sample before, NaN for the first.

    ``stamps_ns`` (n,) ascending, ``values`` (n,). NaN where the stamp is that of the sample before, and after a gap.
    The change of an angle in rad is wrapped to -pi to pi.
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

    ``stamps_ns`` (n,) ascending, ``values`` (n,); values that are not finite are left out. The mean of angles in rad is
    that of their directions.
    """
    if is_angle:
        sine = moving_average(stamps_ns, np.sin(values), window_s)
        return np.arctan2(sine, moving_average(stamps_ns, np.cos(values), window_s))
    is_known = np.isfinite(values)
    level = float(values[is_known].mean()) if is_known.any() else 0.0  # sums of small numbers are more exact
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
