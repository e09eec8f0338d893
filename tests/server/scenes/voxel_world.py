"""Maps of boxes for the tests of drawn voxels, and a plain reader of the chunks that are sent."""

from __future__ import annotations

import struct
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from mapper.volume import OccupancyVolume, VolumeConfig
from mapper.volume.mesh.faces import VoxelFaces, chunks_of, face_rule

SIZE = 0.5
PALETTE = np.array([(255, 0, 0), (0, 0, 255)], np.uint8)
STEPS = ((-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1))  #: towards which each side faces


def blocks_world(*boxes: tuple[tuple[int, int, int], tuple[int, int, int]], colours: int = 2) -> VoxelFaces:
    """The faces of a map in which each box (low, high in voxels from 0, half-open) is occupied."""
    volume = OccupancyVolume(VolumeConfig(resolution=SIZE))
    for low, high in boxes:
        grid = np.stack(np.meshgrid(*map(np.arange, low, high), indexing="ij"), axis=-1).reshape(-1, 3)
        volume.insert_scan((grid + 0.5) * SIZE, None)
    faces = VoxelFaces()
    rule = face_rule(volume, -1e3, 1e3, base=0.0, band=2.0, colours=colours)
    faces.update(volume, rule, chunks_of(volume))
    return faces


def seen_from_inside(rng: np.random.Generator, n_beams: int) -> tuple[OccupancyVolume, VoxelFaces]:
    """A room of 7 m, measured from its middle, and its seen faces: those towards unknown space are left out."""
    away = rng.normal(size=(n_beams, 3))
    points = 3.5 * away / np.abs(away).max(axis=1)[:, None]
    volume = OccupancyVolume(VolumeConfig(resolution=SIZE))
    volume.insert_scan(points.astype(np.float32) + 8.0, np.full(3, 8.0))
    faces = VoxelFaces()
    rule = face_rule(volume, -1e3, 1e3, base=0.0, band=1.0, colours=2, seen_only=True)
    faces.update(volume, rule, chunks_of(volume))
    return volume, faces


def read_chunk(data: bytes) -> Iterator[tuple[tuple[int, int, int], list[int], int, NDArray[np.uint8]]]:
    """Yield each voxel of a chunk: its place, the sides of its faces, its colour from 0, and the table (6, k, 3)."""
    magic, colours, n_pairs, n_voxels = struct.unpack_from("<4sIII", data)
    assert magic == b"GBVX"
    first = 16 + 18 * colours
    table = np.frombuffer(data[16:first], np.uint8).reshape(6, colours, 3)
    pairs, numbers = data[first : first + 2 * n_pairs], list(data[first + 2 * n_pairs :])
    assert len(numbers) == n_voxels
    voxel = number = 0
    for skipped, bits in zip(pairs[::2], pairs[1::2], strict=True):
        voxel += skipped
        if bits:
            number = (number + numbers.pop(0)) % 256
            place = (voxel % 32, voxel // 32 % 32, voxel // 1024)
            yield place, [side for side in range(6) if bits >> side & 1], number, table
            voxel += 1
    assert not numbers
