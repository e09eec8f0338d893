"""Corresponding keypoints of two local maps, and the relative pose on which most of them agree.

Numba twins of :func:`mapper.slam.places_textbook.nearest_descriptors` and
:func:`mapper.slam.places_textbook.pose_of_pairs`.
"""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin

from mapper.core.array_types import Float32Array, Float64Array, Int64Array
from mapper.core.jit import jit


@jit
def nearest_descriptors(ours: Float32Array, theirs: Float32Array, nearest: Int64Array) -> None:
    """Write the indices (m, k) of the descriptors ``theirs`` (n, d) nearest to each of ``ours`` (m, d).

    The nearest comes first; of equal distances the first counts. Rows are padded with −1 if n < k.
    """
    k = nearest.shape[1]
    nearest[:] = -1
    for a in range(len(ours)):
        # The k smallest squared distances so far are kept in order.
        least = [1e300] * k
        for b in range(len(theirs)):
            square = 0.0
            for d in range(ours.shape[1]):
                off = float(ours[a, d]) - float(theirs[b, d])
                square += off * off
            if square < least[k - 1]:
                place = k - 1
                while place > 0 and square < least[place - 1]:
                    least[place], nearest[a, place] = least[place - 1], nearest[a, place - 1]
                    place -= 1
                least[place], nearest[a, place] = square, b


@jit
def pose_of_pairs(
    ours: Float64Array, theirs: Float64Array, owner: Int64Array, guess: Float64Array, window: float,
    turn_window: float, tolerance: float, least_distance: float, pose: Float64Array,
) -> int:  # fmt: skip
    """Write the pose (3,) that aligns most points ``ours`` (c, 2) with ``theirs`` (c, 2); return their number.

    ``owner`` (c,) is the index, ascending, of the point that a pair belongs to: each point counts once. Any two pairs
    of points at least ``least_distance`` apart, whose distances differ by at most ``tolerance`` metres, determine a
    pose; it counts if it is within ``window`` metres and ``turn_window`` radians of ``guess`` (3,). A pair agrees with
    it within ``tolerance``. Of poses with equal counts the one with the least sum of squares is chosen. Returns 0 if no
    pose counts. Source: Fischler & Bolles 1981 (RANSAC), with exhaustive instead of random sampling.
    """
    most, least_sum = 0, 0.0
    for p in range(len(ours)):
        for q in range(p + 1, len(ours)):
            if owner[p] == owner[q]:
                continue
            a_x, a_y = ours[q, 0] - ours[p, 0], ours[q, 1] - ours[p, 1]
            b_x, b_y = theirs[q, 0] - theirs[p, 0], theirs[q, 1] - theirs[p, 1]
            length = hypot(a_x, a_y)
            if length < least_distance or abs(length - hypot(b_x, b_y)) > tolerance:
                continue
            theta = atan2(a_x * b_y - a_y * b_x, a_x * b_x + a_y * b_y)
            off = (theta - guess[2] + pi) % (2.0 * pi) - pi
            if abs(off) > turn_window:
                continue
            c, s = cos(theta), sin(theta)
            m_x, m_y = 0.5 * (ours[p, 0] + ours[q, 0]), 0.5 * (ours[p, 1] + ours[q, 1])
            x = 0.5 * (theirs[p, 0] + theirs[q, 0]) - (c * m_x - s * m_y)
            y = 0.5 * (theirs[p, 1] + theirs[q, 1]) - (s * m_x + c * m_y)
            if hypot(x - guess[0], y - guess[1]) > window:
                continue
            count, total, last, least = 0, 0.0, -1, 0.0
            for k in range(len(ours)):
                d_x = x + c * ours[k, 0] - s * ours[k, 1] - theirs[k, 0]
                d_y = y + s * ours[k, 0] + c * ours[k, 1] - theirs[k, 1]
                square = d_x * d_x + d_y * d_y
                if square > tolerance * tolerance:
                    continue
                if owner[k] != last:
                    count += 1
                    total += square
                    last, least = owner[k], square
                elif square < least:
                    total += square - least
                    least = square
            if count > most or (count == most and count > 0 and total < least_sum):
                most, least_sum = count, total
                pose[0], pose[1], pose[2] = x, y, theta
    return most
