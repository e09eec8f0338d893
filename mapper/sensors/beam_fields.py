"""Perceptual fields of a sensor's beams: the interval of bearings that each beam covers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def beam_fields(
    angle_min: float, angle_increment: float, n_beams: int, widest: float = np.pi / 4.0
) -> NDArray[np.float64]:
    """Return each beam's perceptual field (n_beams, 4): cosine and sine of its right edge, then of its left edge.

    A beam covers the bearings nearer to it than to its neighbours: half an increment to either side, at most
    ``widest``, including the right edge but not the left. Neighbours share an edge to the last bit, so no bearing is
    covered twice; beams beyond one full turn cover nothing. Radians in. Source: Probabilistic Robotics, table 9.2 (β,
    the opening angle).
    """
    turned = abs(angle_increment) * np.arange(n_beams + 1)
    half = min(abs(angle_increment) / 2.0, widest)
    if half < widest:
        edges = angle_min + angle_increment * (np.arange(n_beams + 1) - 0.5)
        edges[turned > 2.0 * np.pi - 1e-6 * abs(angle_increment)] = edges[0]
        ends = np.stack([edges[:-1], edges[1:]] if angle_increment > 0.0 else [edges[1:], edges[:-1]])
    else:
        angles = angle_min + angle_increment * np.arange(n_beams)
        ends = np.stack([angles - half, angles + half])
        ends[:, turned[:-1] > 2.0 * np.pi - 2.0 * half] = angle_min
    return _as_fields(*ends)


def uneven_fields(bearings: NDArray[np.float64], widest: float = np.pi / 4.0) -> NDArray[np.float64]:
    """Return :func:`beam_fields` for bearings (n_beams,) in any order and spacing.

    Of beams with the same bearing, to a nanoradian, the first covers the whole field and the others nothing.
    """
    turn = round(2.0 * np.pi * 1e9)
    places = np.round(np.mod(bearings, 2.0 * np.pi) * 1e9).astype(np.int64) % turn
    places, first = np.unique(places, return_index=True)
    right, left = bearings.copy(), bearings.copy()
    right[first] -= widest
    left[first] += widest
    for n, k in enumerate(first):
        following = first[(n + 1) % len(first)]
        gap = ((places[(n + 1) % len(first)] - places[n]) % turn) * 1e-9
        if len(first) > 1 and gap < 2.0 * widest:
            left[k] = right[following] = bearings[k] + gap / 2.0
    return _as_fields(right, left)


def cones(bearings: NDArray[np.float64], opening: float) -> NDArray[np.float64]:
    """Return the edges (n_beams, 4) of cones of ``opening`` radians, which may overlap, like :func:`beam_fields`."""
    return _as_fields(bearings - opening / 2.0, bearings + opening / 2.0)


def _as_fields(right: NDArray[np.float64], left: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.stack([np.cos(right), np.sin(right), np.cos(left), np.sin(left)], axis=-1)
