"""Local maps of submaps, their corners, and a descriptor of the surroundings of each corner.

Source: Tipaldi & Arras 2010, FLIRT: keypoints of range data with descriptors of occupied and free space around them.
The keypoints here are corners of a local map of several scans, so that they are also found when a place is passed in
the opposite direction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float32Array, Float64Array, Int64Array, UInt8Array
from mapper.core.se2 import compose, inverse
from mapper.slam.kernels.local_map import (
    NO_BIN,
    Square,
    draw_scan,
    write_corner_strengths,
    write_polar_shares,
    write_states,
)
from mapper.slam.scan_store import ScanStore

RESOLUTION = 0.1  #: metres
REACH = 10.0  #: metres: points farther from the sensor are ignored
MOST_SCANS = 16  #: of a submap
BEAMS = 180  #: of a scan
CORNER_RADIUS = 4  #: cells: radius of the walls that form a corner
LEAST_STRENGTH = 0.5  #: minimum strength of a corner, in cells of the weaker wall
APART = 0.5  #: minimum distance of two corners, metres
MOST_CORNERS = 40
RINGS, SECTORS, RADIUS = 5, 24, 30  #: bins of a descriptor, and its radius in cells
FREQUENCIES = 6  #: Fourier coefficients over the sectors


@dataclass(frozen=True, slots=True)
class LocalMap:
    """The corners (k, 2) of the map of some scans, metres in the frame of ``origin``, and their descriptors (k, d).

    ``origin`` is a node index; ``members`` (s,) are the nodes of the submap.
    """

    origin: int
    members: Int64Array
    corners: Float64Array
    descriptors: Float32Array


def local_map(store: ScanStore, members: Int64Array, origin: int, poses: Float64Array) -> LocalMap:
    """Return the local map of the scans ``members`` at ``poses`` (n_scans, 3), in the frame of the scan ``origin``."""
    used = members[np.unique(np.linspace(0, len(members) - 1, min(len(members), MOST_SCANS)).round().astype(np.int64))]
    local = compose(inverse(poses[origin]), poses[used])
    seen = np.array([min(store.farthest(int(k)), REACH) for k in used])
    low = (local[:, :2] - seen[:, np.newaxis]).min(axis=0)
    cols, rows = np.ceil(((local[:, :2] + seen[:, np.newaxis]).max(axis=0) - low) / RESOLUTION).astype(np.int64) + 1
    square = Square(float(low[0]), float(low[1]), RESOLUTION)
    hits, passes = np.zeros((rows, cols), dtype=np.int32), np.zeros((rows, cols), dtype=np.int32)
    tensors, states = np.zeros((rows, cols, 3)), np.empty((rows, cols), dtype=np.uint8)
    stride = max(1, store.n_beams // BEAMS)
    for k, pose in zip(used.tolist(), local, strict=True):
        draw_scan(hits, passes, tensors, square, store.arrays, k, pose, REACH, stride)
    write_states(hits, passes, states)
    strengths = np.empty((rows, cols))
    write_corner_strengths(states, hits, tensors, CORNER_RADIUS, strengths)
    cells = strongest(strengths)
    shares = np.empty((len(cells), 2, RINGS * SECTORS), dtype=np.float32)
    write_polar_shares(states, cells, BINS, SIZES, shares)
    corners = low + (cells[:, ::-1] + 0.5) * RESOLUTION
    return LocalMap(origin, members, corners, frequencies(shares))


def strongest(strengths: Float64Array) -> Int64Array:
    """Return the cells (k, 2), row and column, of the strongest corners that are apart from each other, strongest
    first.

    Of equal ones the first counts.
    """
    corners = np.argwhere(strengths >= LEAST_STRENGTH)
    order = np.argsort(-strengths[corners[:, 0], corners[:, 1]], kind="stable")
    rest, chosen = corners[order], list[Int64Array]()
    while len(rest) and len(chosen) < MOST_CORNERS:
        chosen.append(rest[0])
        rest = rest[np.hypot(*(rest - rest[0]).T) * RESOLUTION > APART]
    return np.array(chosen, dtype=np.int64).reshape(-1, 2)


def frequencies(shares: Float32Array) -> Float32Array:
    """Return descriptors (k, d) that are invariant to rotation, of polar shares (k, 2, rings · sectors).

    They are the amplitudes of the lowest frequencies of the discrete Fourier transform around each ring.
    """
    rings = shares.reshape(-1, 2, RINGS, SECTORS)
    amplitudes = np.abs(np.fft.rfft(rings, axis=-1))[..., :FREQUENCIES] / SECTORS
    return np.ascontiguousarray(amplitudes.reshape(len(shares), 2 * RINGS * FREQUENCIES), dtype=np.float32)


def _polar_bins() -> tuple[UInt8Array, Int64Array]:
    """Return the bin (side, side) of each cell around a keypoint, ring by ring, and the number of cells per bin."""
    row, col = np.mgrid[-RADIUS : RADIUS + 1, -RADIUS : RADIUS + 1]
    ring = np.floor(np.hypot(row, col) * RINGS / (RADIUS + 0.5)).astype(np.int64)
    sector = np.floor(np.arctan2(row, col) / (2.0 * np.pi) * SECTORS).astype(np.int64) % SECTORS
    bins = np.where(ring < RINGS, ring * SECTORS + sector, NO_BIN)
    return bins.astype(np.uint8), np.maximum(np.bincount(bins[bins != NO_BIN], minlength=RINGS * SECTORS), 1)


BINS, SIZES = _polar_bins()
