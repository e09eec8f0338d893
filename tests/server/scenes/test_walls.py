"""The border of a world in a 3D view."""

from __future__ import annotations

import numpy as np

from server.scenes.drawers.walls import BORDER_WIDTH, border


def test_the_border_lies_around_the_world_and_leaves_its_ground_free() -> None:
    x0, y0, x1, y1 = bounds = (-1.0, 2.0, 3.0, 5.0)
    vertices, faces = border(bounds)
    x, y, z = vertices.T.astype(np.float64)
    assert not ((x > x0) & (x < x1) & (y > y0) & (y < y1)).any()
    assert z.max() == 0.0
    a, b, c = (vertices[faces[:, i]].astype(np.float64) for i in range(3))
    areas = np.cross(b - a, c - a)[:, 2] / 2.0
    upper = (areas > 0.0) & (a[:, 2] == 0.0)
    width = 2.0 * BORDER_WIDTH
    frame = (x1 - x0 + width) * (y1 - y0 + width) - (x1 - x0) * (y1 - y0)
    np.testing.assert_allclose(areas[upper].sum(), frame, rtol=1e-5)
