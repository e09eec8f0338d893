"""Low-variance resampling, and the pose bins that particles fill.

Numba twins of :func:`mapper.localization.textbook.low_variance_sampler` and of the bins of
:func:`mapper.localization.textbook.kld_sampling_mcl`.
"""

from __future__ import annotations

from math import floor

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.localization.kernels.types import Bins

_EMPTY = -1
_HALF = 1 << 20  #: bins to each side of 0 along an axis


@jit
def low_variance(weights: Float64Array, first: float, out: Int64Array) -> None:
    """Write the indices of particles drawn by ``weights`` (n,), Σ = 1, into ``out`` (m,); 0 ≤ first < 1/m.

    Source: Probabilistic Robotics, table 4.4, with m independent of the number of particles.
    """
    n, m = weights.shape[0], out.shape[0]
    total, i = weights[0], 0
    for k in range(m):
        u = first + k / m
        while u > total and i < n - 1:
            i += 1
            total += weights[i]
        out[k] = i


@jit
def _bin_of(poses: Float64Array, i: int, bins: Bins) -> int:
    """Return the bin of pose i packed into one integer: 21 bits each for x, y and the angle."""
    a = floor(poses[i, 0] / bins.side) + _HALF
    b = floor(poses[i, 1] / bins.side) + _HALF
    c = floor(poses[i, 2] / bins.turn) + _HALF
    return int((a << 42) | (b << 21) | c)


@jit
def _slot_of(key: int, mask: int) -> int:
    """Return the first slot for ``key`` in a table of mask + 1 slots."""
    low = (key ^ (key >> 21) ^ (key >> 42)) & 0x1FFFFF
    high = (key >> 30) & 0x1FFFFF
    mixed = low * 0x9E3779 + high * 0x85EBCA
    return (mixed ^ (mixed >> 15)) & mask


@jit
def fill_bins(
    poses: Float64Array, chosen: Int64Array, bins: Bins, table: Int64Array, numbers: Int64Array, out: Int64Array
) -> int:
    """Number the bins filled by the particles ``chosen`` (m,) of ``poses`` (n, 3), in order of occurrence.

    ``out`` (m,) is the bin number of each. ``table`` and ``numbers`` (2^k,) with 2^k ≥ 2 m are filled with the bins'
    keys, −1 for empty slots, and their numbers. Returns the number of bins.
    """
    mask = table.shape[0] - 1
    table[:] = _EMPTY
    count, last, number = 0, _EMPTY, 0
    for j in range(chosen.shape[0]):
        key = _bin_of(poses, chosen[j], bins)
        if key != last:  # consecutive entries are often copies of one particle
            last = key
            place = _slot_of(key, mask)
            while table[place] != _EMPTY and table[place] != key:
                place = (place + 1) & mask
            if table[place] == _EMPTY:
                table[place] = key
                numbers[place] = count
                count += 1
            number = numbers[place]
        out[j] = number
    return count


@jit
def _find(parents: Int64Array, i: int) -> int:
    while parents[i] != i:
        parents[i] = parents[parents[i]]
        i = parents[i]
    return i


@jit
def join_bins(table: Int64Array, numbers: Int64Array, turns: int, out: Int64Array) -> int:
    """Write the cluster number of each of k bins into ``out`` (k,); return the number of clusters.

    Bins are connected if x, y and the angle's bin differ by at most one; the angle wraps around after ``turns`` bins.
    Clusters are numbered by their first bins.
    """
    mask, count = table.shape[0] - 1, out.shape[0]
    for i in range(count):
        out[i] = i
    first_turn = -(turns // 2) + _HALF
    for place in range(table.shape[0]):
        key = table[place]
        if key == _EMPTY:
            continue
        a, b, c = key >> 42, (key >> 21) & 0x1FFFFF, key & 0x1FFFFF
        for step in range(14, 27):  # one of each two opposite neighbours
            turn = (c + step % 3 - 1 - first_turn) % turns + first_turn
            other = ((a + step // 9 - 1) << 42) | ((b + step // 3 % 3 - 1) << 21) | turn
            at = _slot_of(other, mask)
            while table[at] != _EMPTY and table[at] != other:
                at = (at + 1) & mask
            if table[at] == other:
                i, j = _find(out, numbers[place]), _find(out, numbers[at])
                if i < j:
                    out[j] = i
                elif j < i:
                    out[i] = j
    clusters = 0
    for i in range(count):
        if out[i] == i:
            out[i] = clusters
            clusters += 1
        else:  # an earlier bin, whose number is final
            out[i] = out[out[i]]
    return clusters


@jit
def add_moments(
    poses: Float64Array, weights: Float64Array, cluster: Int64Array, origin: Float64Array, out: Float64Array
) -> None:
    """Add each particle's weight and moments to the row of its cluster in ``out`` (k, 8).

    The columns are Σw, Σwx, Σwy, Σw cos θ, Σw sin θ, Σwx², Σwxy, Σwy², with x and y relative to ``origin`` (2,).
    """
    for i in range(poses.shape[0]):
        w, k = weights[i], cluster[i]
        x, y = poses[i, 0] - origin[0], poses[i, 1] - origin[1]
        out[k, 0] += w
        out[k, 1] += w * x
        out[k, 2] += w * y
        out[k, 3] += w * np.cos(poses[i, 2])
        out[k, 4] += w * np.sin(poses[i, 2])
        out[k, 5] += w * x * x
        out[k, 6] += w * x * y
        out[k, 7] += w * y * y
