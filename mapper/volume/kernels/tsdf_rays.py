"""Beams in truncated signed distance fields: the voxels around the end of each, beam by beam.

Numba twin of :func:`mapper.volume.surface.textbook.fuse_points`. Source: Curless & Levoy, SIGGRAPH 1996: signed
distances along the line of sight; Amanatides & Woo, 1987, for the voxels on a line.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from mapper.core.array_types import BoolArray, Float32Array, Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.volume.kernels.blocks import block_code, slot_of
from mapper.volume.kernels.types import BlockTable, Fusion

Axis = tuple[int, float, float]  #: step, parameter of the first border and between borders, 0 to 1 along the line


@jit
def _border(at: float, along: float) -> Axis:
    """Return one axis of a line from ``at`` with extent ``along``, in keys."""
    if along == 0.0:
        return 0, np.inf, np.inf
    step = 1 if along > 0.0 else -1
    border = np.floor(at + 0.5) + 0.5 * step
    return step, (border - at) / along, abs(1.0 / along)


@jit
def _line(
    origin: Float64Array, end: Float64Array, resolution: float, fusion: Fusion
) -> tuple[float, tuple[float, float, float], tuple[int, int, int], tuple[Axis, Axis, Axis]]:
    """Return a beam's length in metres, its direction in keys, the first voxel to update, and the axes from there.

    The length is 0 for a beam that updates nothing, because it has no length or is too long.
    """
    dx, dy, dz = end[0] - origin[0], end[1] - origin[1], end[2] - origin[2]
    length = sqrt(dx * dx + dy * dy + dz * dz) * resolution
    if length > fusion.far:
        length = 0.0
    reach = np.float64(fusion.truncation) / length if length > 0.0 else 0.0
    a, b = 0.0 if fusion.carve else max(1.0 - reach, 0.0), 1.0 + reach
    px, py, pz = origin[0] + a * dx, origin[1] + a * dy, origin[2] + a * dz
    first = int(np.floor(px + 0.5)), int(np.floor(py + 0.5)), int(np.floor(pz + 0.5))
    axes = _border(px, (b - a) * dx), _border(py, (b - a) * dy), _border(pz, (b - a) * dz)
    return length, (dx, dy, dz), first, axes


@jit
def beam_blocks(origin: Float64Array, ends: Float64Array, resolution: float, fusion: Fusion, out: Int64Array) -> int:
    """Write the codes of the blocks with voxels that beams pass within the truncation of their ends; return their
    number.

    ``origin`` (3,) and ``ends`` (n, 3) are in keys. ``out`` must be long enough. The voxels are those of
    :func:`fuse_beams`, to the last bit.
    """
    band, n = np.float64(fusion.truncation), 0
    for i in range(ends.shape[0]):
        length, (dx, dy, dz), (x, y, z), axes = _line(origin, ends[i], resolution, fusion)
        if length == 0.0:
            continue
        (step_x, tx, apart_x), (step_y, ty, apart_y), (step_z, tz, apart_z) = axes
        last = -1
        while True:
            code = block_code(x, y, z)
            if code != last:
                along = (ends[i, 0] - x) * dx + (ends[i, 1] - y) * dy + (ends[i, 2] - z) * dz
                distance = along * resolution * resolution / length
                if distance > -band and distance <= band:
                    out[n], last = code, code
                    n += 1
            t = min(tx, ty, tz)
            if t > 1.0:
                break
            if tx == t:
                x, tx = x + step_x, tx + apart_x
            elif ty == t:
                y, ty = y + step_y, ty + apart_y
            else:
                z, tz = z + step_z, tz + apart_z
    return n


@jit
def fuse_beams(
    table: BlockTable, origin: Float64Array, ends: Float64Array, resolution: float, fusion: Fusion,
    distances: Float32Array, weights: Float32Array, out_touched: BoolArray,
) -> None:  # fmt: skip
    """Update the voxels that beams pass, in the order of the beams, and write which blocks (slots,) have changed.

    ``origin`` (3,) and ``ends`` (n, 3) are in keys; ``distances`` and ``weights`` (slots, 512) are the map. Each beam
    that passes a voxel updates it: within the truncation of its end and, if ``fusion.carve``, also farther before it,
    in the blocks of the table.
    """
    band, near = np.float64(fusion.truncation), np.float64(fusion.near)
    most = np.float64(fusion.max_weight)
    for i in range(ends.shape[0]):
        length, (dx, dy, dz), (x, y, z), axes = _line(origin, ends[i], resolution, fusion)
        if length == 0.0:
            continue
        (step_x, tx, apart_x), (step_y, ty, apart_y), (step_z, tz, apart_z) = axes
        base = 1.0 / (length * length) if fusion.inverse_square else 1.0
        code, slot = -1, -1
        while True:
            here = block_code(x, y, z)
            if here != code:
                code = here
                slot = slot_of(table, code)
            if slot >= 0:
                cell = (z & 7) << 6 | (y & 7) << 3 | (x & 7)
                along = (ends[i, 0] - x) * dx + (ends[i, 1] - y) * dy + (ends[i, 2] - z) * dz
                distance = along * resolution * resolution / length
                sure = np.float64(weights[slot, cell])
                if distance > -band and (distance <= band or fusion.carve):
                    w = base * (band + distance) / (band - near) if distance < -near else base
                    mean = (sure * np.float64(distances[slot, cell]) + w * min(distance, band)) / (sure + w)
                    distances[slot, cell] = mean
                    weights[slot, cell] = min(sure + w, most)
                    out_touched[slot] = True
            t = min(tx, ty, tz)
            if t > 1.0:
                break
            if tx == t:
                x, tx = x + step_x, tx + apart_x
            elif ty == t:
                y, ty = y + step_y, ty + apart_y
            else:
                z, tz = z + step_z, tz + apart_z
