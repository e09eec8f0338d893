"""Simple random samples of rows, such as the points of a cloud."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Int64Array


def sample_rows(count: int, most: int) -> Int64Array:
    """Indices (min(count, most),) of rows taken at random without replacement, ascending; the same in each call.

    Every n-th row is no sample of an organised cloud: where n and the number of a lidar's rings, or of an image's
    columns, have a common divisor, those rows are of some of the rings or columns only.
    """
    if count <= most:
        return np.arange(count, dtype=np.int64)
    some = np.random.default_rng(0).choice(count, most, replace=False, shuffle=False)
    return np.sort(some).astype(np.int64, copy=False)
