"""Positions of paths in the 3D view."""

from __future__ import annotations

import numpy as np
import pytest

from server.scenes.drawers.shapes import MAX_SEGMENTS, path_segments


@pytest.mark.parametrize("n", [1, 2, 50, 3 * MAX_SEGMENTS])
def test_a_path_is_one_line(n: int) -> None:
    poses = np.column_stack([np.linspace(0, 9, n), np.linspace(0, 3, n), np.zeros(n)])
    segments = path_segments(poses)
    assert len(segments) <= MAX_SEGMENTS
    assert segments.shape[1:] == (2, 3)
    np.testing.assert_array_equal(segments[1:, 0], segments[:-1, 1])
    if n > 1:
        assert segments[0, 0, :2] == pytest.approx((0.0, 0.0))
