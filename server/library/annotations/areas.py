"""Areas of polygons on a map, given by their corners."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

Corner = tuple[float, float]
THIN = 1e-9  #: of the square of its extent; the corners of a polygon with less area are collinear


def area_of(corners: Sequence[Corner]) -> float:
    """Return the area of a polygon by the shoelace formula, positive if its corners are counter-clockwise."""
    _, crosses = _sums(corners)
    return 0.5 * float(crosses.sum())


def centroid(corners: Sequence[Corner]) -> Corner:
    """Return the centroid of a polygon that is not :func:`is_thin`."""
    sums, crosses = _sums(corners)
    x, y = np.asarray(corners[0]) + (sums * crosses[:, None]).sum(axis=0) / (3.0 * crosses.sum())
    return float(x), float(y)


def is_thin(corners: Sequence[Corner]) -> bool:
    """Return whether the corners of a polygon are collinear: its area is zero up to rounding."""
    extent = float(np.ptp(np.asarray(corners), axis=0).max())
    return abs(area_of(corners)) <= THIN * extent**2


def crosses_itself(corners: Sequence[Corner]) -> bool:
    """Return whether two sides of a polygon cross."""
    begin = np.asarray(corners, dtype=np.float64)
    end = np.roll(begin, -1, axis=0)
    # The side of i on which the ends of side j are. Two sides cross if each separates the ends of the other.
    side = end - begin
    to_begin, to_end = begin[None] - begin[:, None], end[None] - begin[:, None]
    left = side[:, None, 0] * to_begin[..., 1] - side[:, None, 1] * to_begin[..., 0]
    right = side[:, None, 0] * to_end[..., 1] - side[:, None, 1] * to_end[..., 0]
    divides = ((left > 0.0) & (right < 0.0)) | ((left < 0.0) & (right > 0.0))
    return bool((divides & divides.T).any())


def _sums(corners: Sequence[Corner]) -> tuple[np.ndarray, np.ndarray]:
    """Return for each side the sum of its ends (n, 2), and their cross product (n,), both relative to the first corner.

    Far from the map's origin, the products would lose digits.
    """
    begin = np.asarray(corners, dtype=np.float64) - np.asarray(corners[0])
    end = np.roll(begin, -1, axis=0)
    return begin + end, begin[:, 0] * end[:, 1] - end[:, 0] * begin[:, 1]
