"""Extremes per bucket of time, against a loop over the buckets."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mapper.io.contents.downsampling import min_max


def by_loop(stamps: list[int], column: list[float], buckets: int) -> list[tuple[int, float]]:
    """Two rows per bucket of one column, in plain Python."""
    first, span = stamps[0], stamps[-1] - stamps[0]
    held: dict[int, list[int]] = {}
    for at, stamp in enumerate(stamps):
        place = min(int((stamp - first) / span * buckets), buckets - 1) if span else 0
        held.setdefault(place, []).append(at)
    rows: list[tuple[int, float]] = []
    for indices in held.values():
        known = [at for at in indices if not math.isnan(column[at])]
        low = min(known, key=lambda at: column[at], default=None)
        high = max(known, key=lambda at: column[at], default=None)
        pair = [math.nan, math.nan] if low is None or high is None else [column[at] for at in sorted((low, high))]
        rows += zip((stamps[indices[0]], stamps[indices[-1]]), pair, strict=True)
    return rows


@given(
    gaps=st.lists(st.integers(0, 10**9), min_size=1, max_size=60),
    numbers=st.lists(st.sampled_from([-2.0, 0.0, 0.5, 3.0, math.nan]), min_size=60, max_size=60),
    buckets=st.integers(1, 12),
)
def test_as_by_a_loop(gaps: list[int], numbers: list[float], buckets: int) -> None:
    stamps = np.cumsum(gaps, dtype=np.int64)
    values = np.array(numbers[: len(gaps)], dtype=np.float32)[:, None]
    times, least_and_greatest = min_max(stamps, values, buckets)
    if len(gaps) <= 2 * buckets:
        np.testing.assert_array_equal(times, stamps)
        np.testing.assert_array_equal(least_and_greatest, values)
        return
    rows = by_loop(stamps.tolist(), values[:, 0].tolist(), buckets)
    np.testing.assert_array_equal(times, [at for at, _ in rows])
    np.testing.assert_array_equal(least_and_greatest[:, 0], np.array([value for _, value in rows], dtype=np.float32))
    assert len(times) <= 2 * buckets
