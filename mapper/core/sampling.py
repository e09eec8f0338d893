"""Simple random samples of rows, such as the points of a cloud."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Int64Array


def sample_rows(count: int, most: int) -> Int64Array:
    """Return min(count, most) random row indices without replacement, ascending, the same for every call.

    Taking every n-th row of an organised cloud would be biased: if n and the number of rings of a lidar, or of columns
    of an image, share a divisor, only some rings or columns would be sampled.
    """
    if count <= most:
        return np.arange(count, dtype=np.int64)
    some = np.random.default_rng(0).choice(count, most, replace=False, shuffle=False)
    return np.sort(some).astype(np.int64, copy=False)
