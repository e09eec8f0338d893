"""Terrain assessment by planes, in plain NumPy as in a lecture; the kernels must return the same.

A patch's points z = a + b·x + c·y have P = Σ v vᵀ with v = [1 x y z]ᵀ (4 × 4), to which each point adds one term. P
contains AᵀA = P[:3, :3], Aᵀz = P[:3, 3] and zᵀz = P[3, 3] of the least squares, so the points need not be stored.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Moments = NDArray[np.float64]

NOTHING = np.zeros((4, 4))  #: P of no points
FLATNESS = 1e-6  #: points are collinear if det of their covariance is less than this times the trace squared


def add_point(moments: Moments, x: float, y: float, z: float) -> Moments:
    """Return P with one more point."""
    p = np.array([1.0, x, y, z])
    return np.asarray(moments + np.outer(p, p))


def moments_of(points: Iterable[tuple[float, float, float]]) -> Moments:
    """Return P (4, 4) of points (x, y, z) about a centre near them.

    The centre matters: at x = 5·10⁵ m and y = 5·10⁶ m, as in UTM, x² has no digits left for centimetres.
    """
    moments = NOTHING
    for x, y, z in points:
        moments = add_point(moments, x, y, z)
    return moments


def moved(moments: Moments, dx: float, dy: float) -> Moments:
    """Return P of the same points about a centre at (``dx``, ``dy``) relative to the current one: T P Tᵀ."""
    shift = np.eye(4)
    shift[1, 0], shift[2, 0] = -dx, -dy
    return np.asarray(shift @ moments @ shift.T)


@dataclass(frozen=True, slots=True)
class Plane:
    """The plane z = a + b·x + c·y of a patch and its properties; NaN if it has no plane.

    ``residual`` is the sum of squared distances along z, in m², which grows with the number of points; ``roughness`` is
    the root of residual / n, in m. ``slope`` is the angle between the plane and the horizontal, cos⁻¹(1 / √(1 + b² +
    c²)), in radians.
    """

    a: float
    b: float
    c: float
    n: int
    mean_height: float
    residual: float
    roughness: float
    slope: float


def plane_of(moments: Moments) -> Plane:
    """Return the least-squares plane of P (4, 4), which requires three non-collinear points."""
    n = round(moments[0, 0])
    mean = float(moments[0, 3] / n) if n else math.nan
    nothing = Plane(math.nan, math.nan, math.nan, n, mean, math.nan, math.nan, math.nan)
    if n < 3:
        return nothing
    spread = moments[1:3, 1:3] - np.outer(moments[0, 1:3], moments[0, 1:3]) / n
    if np.linalg.det(spread) <= FLATNESS * np.trace(spread) ** 2:
        return nothing
    a, b, c = np.linalg.solve(moments[:3, :3], moments[:3, 3]).tolist()
    residual = max(float(moments[3, 3] - moments[:3, 3] @ (a, b, c)), 0.0)
    slope = math.acos(1.0 / math.sqrt(1.0 + b * b + c * c))
    return Plane(a, b, c, n, mean, residual, math.sqrt(residual / n), slope)


def window_moments(grid: NDArray[np.float64], row: int, col: int, reach: int, size: float) -> Moments:
    """Return P of the patches within ``reach`` rows and columns of a patch, about its centre.

    ``grid`` (rows, cols, 4, 4) has each patch's P about its own centre; patches are squares of ``size`` metres.
    """
    total = NOTHING
    for r in range(max(row - reach, 0), min(row + reach + 1, grid.shape[0])):
        for c in range(max(col - reach, 0), min(col + reach + 1, grid.shape[1])):
            total = total + moved(grid[r, c], (col - c) * size, (row - r) * size)
    return total


def parents(grid: NDArray[np.float64], size: float) -> NDArray[np.float64]:
    """Return the next level of the quadtree (⌈rows / 2⌉, ⌈cols / 2⌉, 4, 4): a parent is the sum of its children."""
    rows, cols = grid.shape[:2]
    out = np.zeros((-(-rows // 2), -(-cols // 2), 4, 4))
    for row, col in np.ndindex(rows, cols):
        dx, dy = (0.5 - col % 2) * size, (0.5 - row % 2) * size
        out[row // 2, col // 2] += moved(grid[row, col], dx, dy)
    return out


def triples_of(n: int, trials: int) -> NDArray[np.int64]:
    """Return triples (m, 3) of ``n`` points for :func:`ransac_plane`: all, if at most ``trials``, else random ones.

    The random numbers are x ← 1664525 x + 1013904223 modulo 2³² starting at x = n, without their last 8 bits (Numerical
    Recipes, 7.1), so that the kernel and the page draw the same triples of n points.
    """
    if math.comb(n, 3) <= trials:
        return np.array(list(itertools.combinations(range(n), 3)), dtype=np.int64).reshape(-1, 3)
    state, triples = n, []
    for _ in range(trials):
        triple: list[int] = []
        for left in (n, n - 1, n - 2):
            state = (1664525 * state + 1013904223) % 2**32
            chosen = (state >> 8) % left
            for index in sorted(triple):
                chosen += chosen >= index
            triple.append(chosen)
        triples.append(triple)
    return np.array(triples, dtype=np.int64)


def ransac_plane(
    points: NDArray[np.float64], triples: NDArray[np.int64], distance: float
) -> tuple[Plane, NDArray[np.bool_]]:
    """Return the plane with the most inliers, and the inliers (n,).

    Each of ``triples`` (m, 3) are indices of three points, whose plane has the points within ``distance`` along z as
    inliers. The first triple with the most inliers is chosen, and the plane is fitted to them. Source: Fischler &
    Bolles, Random Sample Consensus, 1981.
    """
    best = np.zeros(len(points), dtype=np.bool_)
    for triple in triples:
        plane = plane_of(moments_of(points[triple].tolist()))
        inside = np.abs(points[:, 2] - plane.a - points[:, :2] @ (plane.b, plane.c)) <= distance
        if inside.sum() > best.sum():
            best = inside
    return plane_of(moments_of(points[best].tolist())), best


def score(
    slope: float, roughness: float, step: float, most: tuple[float, float, float], weights: tuple[float, float, float]
) -> float:
    """Return the weighted sum of a patch's properties, each divided by its maximum safe value; unsafe above 1."""
    return sum(w * (value / limit) for w, value, limit in zip(weights, (slope, roughness, step), most, strict=True))


def greatest(
    slope: float, roughness: float, step: float, most: tuple[float, float, float], weights: tuple[float, float, float]
) -> float:
    """Return the maximum term of :func:`score`: above 1 if a single property exceeds its threshold."""
    return max(w * (value / limit) for w, value, limit in zip(weights, (slope, roughness, step), most, strict=True))


def step(planes: list[list[Plane]], row: int, col: int, size: float) -> float:
    """Return the maximum gap between a patch's plane and a neighbour's, at the middle of their common edge."""
    here, largest = planes[row][col], 0.0
    for down, right in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        r, c = row + down, col + right
        if 0 <= r < len(planes) and 0 <= c < len(planes[0]) and not math.isnan(planes[r][c].a):
            there, x, y = planes[r][c], 0.5 * size * right, 0.5 * size * down
            gap = (here.a + here.b * x + here.c * y) - (there.a - there.b * x - there.c * y)
            largest = max(largest, abs(gap))
    return largest
