"""Truncated signed distances and their meshes, for the table: random depth images, beams and fields."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mapper.sensors.camera import Intrinsics
from mapper.volume import TsdfConfig, TsdfVolume, surface_mesh
from mapper.volume.blocks import BLOCK
from mapper.volume.mesh import textbook as textbook_marching
from mapper.volume.mesh.mesh import Mesh
from mapper.volume.mesh.meshing import blocks_of_change
from mapper.volume.surface import textbook as textbook_tsdf
from mapper.volume.surface.tsdf import CENTRE

CAMERA = Intrinsics(22, 17, 15.0, 16.0, 10.3, 8.2)
REACH = 2.4  # metres from 0 that a case may see: the corners of an image, behind its farthest depth


@dataclass(frozen=True)
class DepthCase:
    """Depth images with poses, and how they become a map."""

    config: TsdfConfig
    frames: list[tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class BeamCase:
    """Scans, each points and an origin, and how they become a map."""

    config: TsdfConfig
    scans: list[tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class FieldCase:
    """Distances and weights (nz, ny, nx), the key of the first voxel, and the least weight of a mesh."""

    distances: np.ndarray
    weights: np.ndarray
    corner: np.ndarray
    least_weight: float


def configs(draw: st.DrawFn) -> TsdfConfig:
    resolution = draw(st.sampled_from([0.1, 0.125]))
    return TsdfConfig(
        resolution=resolution,
        truncation=draw(st.sampled_from([0.0, 2.5 * resolution])),
        max_weight=draw(st.sampled_from([1.5, 64.0])),
        weighting=draw(st.sampled_from(["constant", "inverse_square"])),
        drop_off=draw(st.booleans()),
        carve=draw(st.booleans()),
        range_max=draw(st.sampled_from([0.0, 0.7])),
    )


@st.composite
def depth_cases(draw: st.DrawFn) -> DepthCase:
    """Walls and steps with noise, seen by a small camera from places that differ a little; some pixels lack a depth."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    frames = []
    turn = Rotation.random(random_state=rng)
    for _ in range(draw(st.integers(1, 3))):
        pose = np.eye(4)
        pose[:3, :3] = (Rotation.from_rotvec(rng.normal(0.0, 0.1, 3)) * turn).as_matrix()
        pose[:3, 3] = rng.normal(0.0, 0.1, 3)
        v, u = np.indices((CAMERA.height, CAMERA.width))
        depth = 0.6 + 0.01 * (u - 10) * rng.normal() + 0.01 * (v - 8) * rng.normal()
        depth[(u > rng.integers(4, 22)) & (v > rng.integers(0, 10))] += rng.uniform(-0.3, 0.3)
        depth += rng.normal(0.0, draw(st.sampled_from([0.0, 0.02])), depth.shape)
        depth = np.clip(depth, 0.2, 0.9).astype(np.float32)
        depth[rng.random(depth.shape) < 0.1] = rng.choice([np.nan, 0.0, np.inf, -1.0])
        frames.append((depth, pose))
    return DepthCase(configs(draw), frames)


@st.composite
def beam_cases(draw: st.DrawFn) -> BeamCase:
    """Points about a sensor; some on it, some along the axes."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    scans = []
    for _ in range(draw(st.integers(1, 3))):
        origin = rng.normal(0.0, 0.3, 3)
        points = origin + rng.normal(0.0, 0.6, (draw(st.sampled_from([1, 12])), 3))
        points[rng.random(points.shape) < 0.2] = 0.0
        points = np.concatenate([points, origin[None]])
        scans.append((points, origin))
    return BeamCase(configs(draw), scans)


@st.composite
def field_cases(draw: st.DrawFn) -> FieldCase:
    """Random signs, in which every case of a cube occurs, or a smooth surface; some voxels are unknown."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    shape = (6, 7, 11)
    if draw(st.booleans()):
        distances = rng.normal(0.0, 0.1, shape)
    else:
        z, y, x = np.indices(shape)
        distances = 0.3 * (np.sqrt((z - 2.6) ** 2 + (y - 3.1) ** 2 + (0.5 * x - 2.7) ** 2) - 2.2)
    weights = np.where(rng.random(shape) < draw(st.sampled_from([0.0, 0.1])), 0.0, rng.uniform(0.5, 3.0, shape))
    corner = CENTRE + rng.integers(-12, 12, 3)
    return FieldCase(
        distances.astype(np.float32), weights.astype(np.float32), corner, draw(st.sampled_from([0.0, 1.0]))
    )


def known(volume: TsdfVolume) -> tuple[Any, ...]:
    """The keys of the known voxels in order, their distances and weights."""
    slot, z, y, x = np.nonzero(volume.weights)
    keys = volume.blocks.corners[slot] + np.stack([x, y, z], axis=1)
    order = np.lexsort(keys.T)
    return keys[order], volume.distances[slot, z, y, x][order], volume.weights[slot, z, y, x][order]


def depths_in_tsdf_by_kernel(case: DepthCase) -> tuple[Any, ...]:
    volume = TsdfVolume(case.config)
    # Without the compiler, what is computed for voxels that the image does not show, and not used, would warn.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for depth, pose in case.frames:
            volume.fuse_depth(depth, CAMERA, pose)
    return known(volume)


def depths_in_tsdf_by_textbook(case: DepthCase) -> tuple[Any, ...]:
    most = int(REACH / case.config.resolution)
    z, y, x = np.indices((2 * most,) * 3).reshape(3, -1) + CENTRE - most
    keys = np.stack([x, y, z], axis=1)
    distances, weights = np.zeros(len(keys), dtype=np.float32), np.zeros(len(keys), dtype=np.float32)
    for depth, pose in case.frames:
        textbook_tsdf.fuse_depth(keys, distances, weights, depth, CAMERA, pose, case.config)
    seen = weights > 0.0
    order = np.lexsort(keys[seen].T)
    return keys[seen][order], distances[seen][order], weights[seen][order]


def beams_in_tsdf_by_kernel(case: BeamCase) -> tuple[Any, ...]:
    volume = TsdfVolume(case.config)
    for points, origin in case.scans:
        volume.fuse_points(points, origin)
    return known(volume)


def beams_in_tsdf_by_textbook(case: BeamCase) -> tuple[Any, ...]:
    surface: textbook_tsdf.Surface = {}
    for points, origin in case.scans:
        textbook_tsdf.fuse_points(surface, points, origin, case.config)
    keys = np.array(list(surface), dtype=np.int64).reshape(-1, 3)
    values = np.array(list(surface.values()), dtype=np.float32).reshape(-1, 2)
    order = np.lexsort(keys.T)
    return keys[order], values[order, 0], values[order, 1]


def volume_of(case: FieldCase) -> TsdfVolume:
    """A map with that field."""
    volume = TsdfVolume(TsdfConfig(resolution=0.1))
    z, y, x = (axis.reshape(-1) for axis in np.indices(case.distances.shape))
    keys = case.corner + np.stack([x, y, z], axis=1)
    codes, block = np.unique(keys // BLOCK @ np.array([1, 1 << 13, 1 << 26]), return_inverse=True)
    distances = np.zeros((len(codes), BLOCK, BLOCK, BLOCK), dtype=np.float32)
    weights = np.zeros_like(distances)
    at = block, *(keys % BLOCK).T[::-1]
    distances[at], weights[at] = case.distances.reshape(-1), case.weights.reshape(-1)
    volume.set_blocks(codes, distances, weights)
    return volume


def mesh_by_kernel(case: FieldCase) -> tuple[Any, ...]:
    """The mesh of the whole, and that of each block after the other."""
    volume = volume_of(case)
    whole = surface_mesh(volume, least_weight=case.least_weight)
    every = np.arange(volume.blocks.count, dtype=np.int32)
    assert np.array_equal(blocks_of_change(volume, every), every)
    parts = [surface_mesh(volume, every[k : k + 1], least_weight=case.least_weight) for k in every]
    corners = np.concatenate([part.vertices[part.triangles] for part in parts])
    return (*in_order(whole), ordered(corners))


def mesh_by_textbook(case: FieldCase) -> tuple[Any, ...]:
    sure = case.weights >= np.float32(max(case.least_weight, 1e-30))
    mesh = textbook_marching.march(case.distances, sure, case.corner, 0.1)
    vertices, normals, triangles = in_order(mesh)
    return vertices, normals, triangles, triangles


def in_order(mesh: Mesh) -> tuple[Any, ...]:
    """The vertices in order with their normals, and the corners of the triangles in order."""
    order = np.lexsort(mesh.vertices.T)
    return mesh.vertices[order], mesh.normals[order], ordered(mesh.vertices[mesh.triangles])


def ordered(corners: np.ndarray) -> np.ndarray:
    """Triangles (m, 3, 3) as rows of nine numbers in order, each from its least corner on, turning as before."""
    if not len(corners):
        return np.zeros((0, 9), dtype=np.float32)
    turned = np.stack([np.roll(corners, -k, axis=1).reshape(-1, 9) for k in range(3)])
    least = np.array([min(range(3), key=lambda k: tuple(turned[k, i])) for i in range(len(corners))])
    rows: np.ndarray = turned[least, np.arange(len(corners))]
    return np.take(rows, np.lexsort(rows.T), axis=0)
