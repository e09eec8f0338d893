"""Normals of voxels against planes and a sphere whose normals are known."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.array_types import Float64Array
from mapper.volume import OccupancyVolume, VolumeConfig
from mapper.volume.mesh.faces import CENTRE, CHUNK, chunks_of
from mapper.volume.mesh.voxel_normals import direction_numbers, directions, voxel_normals


def all_normals(volume: OccupancyVolume) -> tuple[Float64Array, Float64Array]:
    """The centres (n, 3), metres, of the occupied voxels and their normals (n, 3)."""
    centres, normals = [np.empty((0, 3))], [np.empty((0, 3))]
    for chunk in chunks_of(volume):
        numbers, found = voxel_normals(volume, chunk)
        place = np.stack([numbers % CHUNK, numbers // CHUNK % CHUNK, numbers // CHUNK**2], axis=1)
        centres.append((place + CHUNK * np.array(chunk) - CENTRE + 0.5) * volume.config.resolution)
        normals.append(found)
    return np.concatenate(centres), np.concatenate(normals)


@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.6, 0.0, 0.8)])
def test_a_plane_faces_its_sensor(normal: tuple[float, float, float]) -> None:
    away = np.array(normal)
    u = np.cross(away, (0.3, 0.5, 0.8))
    u /= np.linalg.norm(u)
    v = np.cross(away, u)
    a, b = np.meshgrid(np.linspace(-1.5, 1.5, 120), np.linspace(-1.5, 1.5, 120))
    points = 0.012 + a.reshape(-1, 1) * u + b.reshape(-1, 1) * v
    volume = OccupancyVolume(VolumeConfig(resolution=0.05))
    volume.insert_scan(points, 2.0 * away)
    centres, normals = all_normals(volume)
    inner = np.linalg.norm(centres, axis=1) < 1.2  # at the border the plane ends
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    assert ((normals @ away)[inner] > 0.9).mean() > 0.99


def test_a_sphere_without_a_sensor_has_normals_along_its_radii() -> None:
    rng = np.random.default_rng(3)
    radial = rng.normal(size=(200_000, 3))
    radial /= np.linalg.norm(radial, axis=1)[:, None]
    volume = OccupancyVolume(VolumeConfig(resolution=0.05))
    volume.insert_scan(radial, None)
    centres, normals = all_normals(volume)
    along = np.abs((normals * centres).sum(axis=1)) / np.linalg.norm(centres, axis=1)
    assert np.median(along) > 0.97
    assert (normals[:, 2] >= -1e-9).all()  # neither side is known to be free


def test_a_direction_keeps_its_number_and_axes_have_their_own() -> None:
    known = directions()
    some = np.array([(1.0, 0, 0), (-1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0), (0, 0, -1.0), (0.6, 0.0, 0.8)])
    numbers = direction_numbers(some)
    assert numbers.min() >= 1
    assert numbers[0] // 2 == numbers[1] // 2 or numbers[0] == numbers[1]
    assert len(set(numbers[[0, 2, 3, 4]].tolist())) == 4
    near = known[numbers.astype(int) - 1]
    assert (np.abs(near) - np.abs(some) < 0.1).all()
    assert np.sign(near[3:, 2]).tolist() == [1.0, -1.0, 1.0]
