"""Surfaces out of depth images and points: known shapes, closed meshes, limits, and files that trimesh reads."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from mapper.core.errors import ConfigError, LimitError
from mapper.core.limits import Limits
from mapper.core.parallel import single_threaded
from mapper.io.clouds import read_cloud
from mapper.sensors.camera import Intrinsics
from mapper.volume import Mesh, TsdfConfig, TsdfVolume, surface_mesh
from mapper.volume.blocks import BLOCK
from mapper.volume.mesh.cube_cases import polygons
from mapper.volume.mesh.files import write_mesh
from mapper.volume.mesh.meshing import blocks_of_change
from mapper.volume.surface.tsdf import CENTRE

CAMERA = Intrinsics(80, 60, 70.0, 70.0, 39.5, 29.5)
# A camera at the origin that looks along x: its z is our x, its x our −y, its y our −z.
AHEAD = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])


def sphere(radius: float = 0.83, resolution: float = 0.1) -> TsdfVolume:
    """The distances to a sphere about a point that is no voxel's centre, in 4 × 4 × 4 blocks."""
    volume = TsdfVolume(TsdfConfig(resolution=resolution))
    z, y, x = np.indices((4, 4, 4)).reshape(3, -1) + CENTRE // BLOCK - 2
    codes = z << 26 | y << 13 | x
    k, j, i = np.indices((BLOCK,) * 3)
    places = np.stack([axis[:, None, None, None] * BLOCK + at for axis, at in ((x, i), (y, j), (z, k))], axis=-1)
    places = (places - CENTRE + 0.5) * resolution - [0.013, -0.027, 0.031]
    distances = (np.linalg.norm(places, axis=-1) - radius).astype(np.float32)
    volume.set_blocks(codes, distances, np.ones_like(distances))
    return volume


def test_a_sphere_is_closed_and_has_its_size_and_normals() -> None:
    mesh = surface_mesh(sphere())
    solid = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
    assert solid.is_watertight
    assert solid.is_winding_consistent
    assert solid.euler_number == 2
    assert solid.volume == pytest.approx(4.0 / 3.0 * np.pi * 0.83**3, rel=0.01)  # positive: triangles face outwards
    away = mesh.vertices - np.array([0.013, -0.027, 0.031])
    assert np.abs(np.linalg.norm(away, axis=1) - 0.83).max() < 0.003
    np.testing.assert_allclose(mesh.normals, away / np.linalg.norm(away, axis=1)[:, None], atol=0.03)
    assert len(np.unique(mesh.triangles)) == len(mesh.vertices)


def test_any_signs_make_a_closed_surface() -> None:
    """The 256 cases fit each other: noise with a positive border has no open edge, and no edge with three triangles."""
    volume = TsdfVolume(TsdfConfig(resolution=0.1))
    rng = np.random.default_rng(3)
    distances = np.ones((16, 16, 16), dtype=np.float32)
    distances[1:-1, 1:-1, 1:-1] = rng.normal(size=(14, 14, 14))
    blocks = distances.reshape(2, 8, 2, 8, 2, 8).transpose(0, 2, 4, 1, 3, 5).reshape(8, 8, 8, 8)
    z, y, x = np.indices((2, 2, 2)).reshape(3, -1) + CENTRE // BLOCK
    volume.set_blocks(z << 26 | y << 13 | x, np.ascontiguousarray(blocks), np.ones_like(blocks))
    mesh = surface_mesh(volume)
    solid = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
    edges = np.concatenate([mesh.triangles[:, [0, 1]], mesh.triangles[:, [1, 2]], mesh.triangles[:, [2, 0]]])
    there, back = edges, edges[:, ::-1]
    first, second = (one[np.lexsort(one.T)] for one in (there, back))
    np.testing.assert_array_equal(first, second)  # each edge is passed once each way, or as often each way
    assert solid.is_winding_consistent
    assert {case for case in range(256) if not polygons(case)} == {0, 255}


def test_depth_images_of_a_wall_are_where_it_stands() -> None:
    volume = TsdfVolume(TsdfConfig(resolution=0.02))
    for shift in (0.0, 0.05):
        pose = AHEAD.copy()
        pose[0, 3] = shift
        volume.fuse_depth(np.full((60, 80), 1.007 - shift, np.float32), CAMERA, pose)
    mesh = surface_mesh(volume)
    np.testing.assert_allclose(mesh.vertices[:, 0], 1.007, atol=1e-5)
    np.testing.assert_allclose(mesh.normals, np.tile([-1.0, 0.0, 0.0], (len(mesh.normals), 1)), atol=1e-5)
    assert mesh.area == pytest.approx((80 / 70 * 1.007) * (60 / 70 * 1.007), rel=0.1)


def test_points_of_a_wall_are_where_it_stands() -> None:
    """Seen from the side, the distance along the beam is 0 where the distance to the wall is."""
    y, z = np.meshgrid(np.linspace(-0.3, 0.9, 200), np.linspace(-0.4, 0.4, 200))
    points = np.stack([np.full(y.size, 0.913), y.ravel(), z.ravel()], axis=1)
    volume = TsdfVolume(TsdfConfig(resolution=0.04))
    did = volume.fuse_points(np.concatenate([points, [[np.nan, 0.0, 0.0]]]), [0.0, 0.0, 0.0])
    assert did.used == len(points)
    mesh = surface_mesh(volume)
    assert len(mesh.triangles) > 500
    np.testing.assert_allclose(mesh.vertices[:, 0], 0.913, atol=0.02)
    assert np.abs(np.median(mesh.vertices[:, 0]) - 0.913) < 0.002


def test_what_is_seen_through_goes_away() -> None:
    """A box is taken away: with carving its surface is gone once the wall behind it was seen more often."""
    left = {}
    for carve in (True, False):
        volume = TsdfVolume(TsdfConfig(resolution=0.05, carve=carve))
        depth = np.full((60, 80), 2.0, np.float32)
        box = depth.copy()
        box[20:40, 30:50] = 1.0
        for image in (box, box, depth, depth, depth):
            volume.fuse_depth(image, CAMERA, AHEAD)
        mesh = surface_mesh(volume)
        left[carve] = int((mesh.vertices[:, 0] < 1.5).sum())
    assert left[True] == 0
    assert left[False] > 20


def test_changed_blocks_are_named_and_threads_do_not_matter() -> None:
    rng = np.random.default_rng(5)
    depth = rng.uniform(1.0, 1.4, (60, 80)).astype(np.float32)
    several, one = TsdfVolume(TsdfConfig(resolution=0.02)), TsdfVolume(TsdfConfig(resolution=0.02))
    did = several.fuse_depth(depth, CAMERA, AHEAD)
    with single_threaded():
        one.fuse_depth(depth, CAMERA, AHEAD)
        alone = surface_mesh(one)
    np.testing.assert_array_equal(several.distances, one.distances)
    np.testing.assert_array_equal(several.blocks.codes, one.blocks.codes)
    np.testing.assert_array_equal(surface_mesh(several).vertices, alone.vertices)
    np.testing.assert_array_equal(did.slots, np.arange(several.blocks.count))

    before = several.weights.copy()
    part = np.full_like(depth, np.nan)
    part[:8, :8] = depth[:8, :8]
    did = several.fuse_depth(part, CAMERA, AHEAD)
    changed = np.flatnonzero((several.weights != before).any(axis=(1, 2, 3)))
    np.testing.assert_array_equal(did.slots, changed)
    assert did.used == 64
    affected = blocks_of_change(several, did.slots)
    others = np.setdiff1d(np.arange(several.blocks.count, dtype=np.int32), affected)
    for mine, theirs in zip(*(surface_mesh(v, others).vertices for v in (several, one)), strict=True):
        np.testing.assert_array_equal(mine, theirs)


def test_bad_input_is_refused_and_the_map_stays() -> None:
    volume = TsdfVolume(TsdfConfig(resolution=0.02), Limits(max_blocks=100))
    depth = np.full((60, 80), 1.0, np.float32)
    no_rotation = AHEAD.copy()
    no_rotation[:3, :3] *= 1.1
    for image, pose, said in (
        (depth[:-1], AHEAD, "80 × 59 pixels has intrinsics for 80 × 60"),
        (depth, no_rotation, "not a rotation"),
        (depth, AHEAD * np.nan, "not finite"),
    ):
        with pytest.raises(ConfigError, match=said):
            volume.fuse_depth(image, CAMERA, pose)
    with pytest.raises(LimitError, match="more than 50; choose a coarser resolution"):
        volume.fuse_depth(depth, CAMERA, AHEAD)
    with pytest.raises(LimitError, match="choose a coarser resolution"):
        TsdfVolume(TsdfConfig(resolution=0.001)).fuse_depth(depth * 400.0, CAMERA, AHEAD)
    with pytest.raises(LimitError, match="more than 50"):
        volume.fuse_points(np.random.default_rng(0).normal(size=(100, 3)), [0, 0, 0])
    with pytest.raises(ConfigError, match="within"):
        volume.fuse_points([[1.0, 0, 0]], [1e6, 0, 0])
    with pytest.raises(ConfigError, match="less than two voxels"):
        TsdfConfig(resolution=0.1, truncation=0.15)
    assert volume.blocks.count == 0
    assert volume.fuse_depth(depth * np.nan, CAMERA, AHEAD).used == 0
    assert len(surface_mesh(volume).triangles) == 0


def test_another_program_reads_the_files(tmp_path: Path) -> None:
    """The normals, which trimesh makes again, are read by our reader of clouds and by glTF's description."""
    mesh = surface_mesh(sphere())
    for ending in (".ply", ".glb"):
        write_mesh(mesh, tmp_path / f"ball{ending}")
        read: Any = trimesh.load(tmp_path / f"ball{ending}", force="mesh", process=False)
        turned = mesh.vertices if ending == ".ply" else mesh.vertices[:, [0, 2, 1]] * [1, 1, -1]  # y up
        np.testing.assert_allclose(read.vertices, turned, atol=1e-6)
        np.testing.assert_array_equal(read.faces, mesh.triangles)
    np.testing.assert_array_equal(read_cloud(tmp_path / "ball.ply").fields["normals"], mesh.normals)
    content = (tmp_path / "ball.glb").read_bytes()
    (n_text,) = struct.unpack_from("<I", content, 12)
    tree = json.loads(content[20 : 20 + n_text])
    accessor = tree["accessors"][tree["meshes"][0]["primitives"][0]["attributes"]["NORMAL"]]
    at = 28 + n_text + tree["bufferViews"][accessor["bufferView"]]["byteOffset"]
    normals = np.frombuffer(content, "<f4", 3 * accessor["count"], at).reshape(-1, 3)
    np.testing.assert_array_equal(normals, mesh.normals)
    assert struct.unpack_from("<4sII", content) == (b"glTF", 2, len(content))


def test_an_empty_mesh_and_another_ending_are_refused(tmp_path: Path) -> None:
    empty = Mesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))
    write_mesh(empty, tmp_path / "none.ply")
    with pytest.raises(ConfigError, match="without triangles"):
        write_mesh(empty, tmp_path / "none.glb")
    with pytest.raises(ConfigError, match=r"\.ply or \.glb"):
        write_mesh(empty, tmp_path / "none.stl")
