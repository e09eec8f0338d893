"""Surfaces of sequences of scans: any scan is gone to, chunks make up the whole mesh, voxels are asked about."""

from __future__ import annotations

import io
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
import trimesh

from mapper.core.errors import ConfigError
from mapper.sensors.camera import Intrinsics
from mapper.volume import TsdfConfig, TsdfVolume, surface_mesh
from mapper.volume.kernels.faces import CHUNK
from mapper.volume.mesh.chunk_mesh import STEPS, cut_between, shaded
from mapper.volume.mesh.surface_chunks import SurfaceChunks
from mapper.volume.scans.depth_sequence import DepthSequence, GatheredDepth
from mapper.volume.scans.scan_sequence import UPS, ScanSequence
from mapper.volume.surface.questions import first_surface, why_surface
from mapper.volume.surface.replayed import ReplayedSurface
from mapper.volume.surface.tsdf import CENTRE
from server.scenes.chunk_glb import LIGHT
from server.scenes.drawers.chunks import surface_glb

CAMERA = Intrinsics(80, 60, 70.0, 70.0, 39.5, 29.5)
AHEAD = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
CONFIG = TsdfConfig(resolution=0.05)


def images(n: int = 18) -> ScanSequence:
    """Depth images of a wall 2 m ahead of a camera that moves to the left; from the tenth on a box stands before it."""
    depths = np.full((n, 60, 80), 2000, dtype=np.uint16)
    depths[n // 2 :, 20:40, 30:50] = 1500
    depths[:, :2] = 0
    poses = np.repeat(AHEAD[None], n, axis=0)
    poses[:, 1, 3] = np.linspace(0.0, 0.4, n)
    points = [
        (CAMERA.points(depth * np.float32(0.001)) @ pose[:3, :3].T + pose[:3, 3])[160:]
        for depth, pose in zip(depths, poses, strict=True)
    ]
    starts = np.cumsum([0, *map(len, points)])
    return ScanSequence(
        "depth images", np.concatenate(points).astype(np.float32), starts, poses[:, :3, 3], np.zeros(n, np.int64),
        np.zeros(3), depth=DepthSequence(CAMERA, 0.001, depths, poses),
    )  # fmt: skip


def without_images(source: ScanSequence) -> ScanSequence:
    return ScanSequence(source.kind, source.points, source.starts, source.origins, source.stamps_ns, source.offset)


def test_going_back_begins_at_a_snapshot_and_the_surface_is_that_of_fusing_all() -> None:
    source = images()
    assert source.depth is not None
    now = ReplayedSurface(source, CONFIG)
    assert now.go_to(18)
    assert now.snapshots == (8, 16)
    for index in (17, 9, 3, 12):
        asked = Mock(return_value=True)
        now.go_to(index, may_continue=asked)
        expected = TsdfVolume(CONFIG)
        for k in range(index):
            expected.fuse_depth(source.depth.depth(k), CAMERA, source.depth.poses[k])
        order, other = np.argsort(now.volume.blocks.codes), np.argsort(expected.blocks.codes)
        np.testing.assert_array_equal(now.volume.distances[order], expected.distances[other])
        np.testing.assert_array_equal(now.volume.weights[order], expected.weights[other])
        assert len(now.counts) == index
        assert asked.call_count == {17: 1, 9: 1, 3: 3, 12: 9}[index]
    # With little room for snapshots fewer are kept, and the surface is the same.
    small = ReplayedSurface(source, CONFIG, snapshot_bytes=now.volume.n_bytes)
    small.go_to(18)
    assert len(small.snapshots) < 2


def test_chunks_of_changes_make_up_the_mesh_of_all() -> None:
    source, chunks = images(), SurfaceChunks()
    now = ReplayedSurface(source, CONFIG)
    kept = {}
    for index in (5, 12, 18, 6, 14):
        now.go_to(index)
        chunks.note_change(now.volume, now.take_touched())
        while chunks.pending:
            chunks.work(now.volume, lambda: True)
        whole = surface_mesh(now.volume)
        joined: Any = trimesh.util.concatenate(
            [
                trimesh.Trimesh(
                    (mesh.places / STEPS + CHUNK * np.array(key) - CENTRE + 0.5) * CONFIG.resolution, mesh.triangles,
                    process=False,
                )
                for key, mesh in chunks.chunks.items()
            ]
        )  # fmt: skip
        assert len(joined.faces) == len(whole.triangles) == chunks.n_triangles > 500
        assert joined.area == pytest.approx(whole.area, rel=1e-4)
        # Places on the borders of chunks are the same in both: joined they have no more vertices than the whole, and a
        # few less, where two were so near to each other that they have one place.
        joined.merge_vertices(digits_vertex=6)
        assert 0.98 * len(whole.vertices) < len(joined.vertices) <= len(whole.vertices)
        if index == 18:
            kept = dict(chunks.chunks)
    # Nothing has changed: no object is another one.
    now.go_to(18)
    chunks.note_change(now.volume, None)
    chunks.work(now.volume)
    before = dict(chunks.chunks)
    chunks.note_change(now.volume, None)
    chunks.work(now.volume)
    assert all(chunks.chunks[key] is mesh for key, mesh in before.items())
    assert kept.keys() == before.keys()


def test_a_chunk_is_cut_and_written_as_another_reader_takes_it() -> None:
    now, chunks = ReplayedSurface(images(), CONFIG), SurfaceChunks()
    now.go_to(4)
    chunks.note_change(now.volume, now.take_touched())
    chunks.work(now.volume)
    mesh = max(chunks.chunks.values(), key=lambda one: len(one.triangles))
    assert cut_between(mesh, 0, STEPS * CHUNK) is mesh
    assert cut_between(mesh, -9, -1) is None
    wide = np.flatnonzero(np.ptp(mesh.places[mesh.triangles.ravel()], axis=0))
    assert len(wide) >= 2
    for axis in wide:
        high = np.full(3, np.inf)
        high[axis] = middle = float(np.median(mesh.places[:, axis]))
        cut = cut_between(mesh, 0, high)
        assert cut is not None
        assert 0 < len(cut.triangles) < len(mesh.triangles)
        assert mesh.places[cut.triangles, axis].max() <= middle
    colors = np.full((len(mesh.places), 3), 200, dtype=np.uint8)
    read = trimesh.load_mesh(io.BytesIO(surface_glb(mesh, colors)), file_type="glb", process=False)
    np.testing.assert_array_equal(read.faces, mesh.triangles)
    np.testing.assert_array_equal(read.vertices, mesh.places)
    # A normal along an axis has the light of a voxel's face of that side.
    axes = np.array([(-127, 0, 0), (127, 0, 0), (0, -127, 0), (0, 127, 0), (0, 0, -127), (0, 0, 127)], np.int8)
    white = shaded(np.full((6, 3), 255, np.uint8), axes, LIGHT.astype(np.float32))
    np.testing.assert_allclose(white[:, 0] / 255.0, LIGHT**2.2, atol=0.005)


@pytest.mark.parametrize("drop_off", [False, True])
@pytest.mark.parametrize("as_points", [False, True])
def test_what_scans_did_to_a_voxel_sums_up_to_the_surface(drop_off: bool, as_points: bool) -> None:
    source = without_images(images(12)) if as_points else images(12)
    config = TsdfConfig(resolution=0.1, max_weight=5.0, weighting="inverse_square", drop_off=drop_off)
    now = ReplayedSurface(source, config)
    now.go_to(12)
    volume = now.volume
    rng = np.random.default_rng(2)
    known = np.argwhere(volume.weights > 0.0)
    measured = []
    for slot, z, y, x in rng.choice(known, 25, replace=False):
        updates = why_surface(now, volume.blocks.corners[slot] + np.array([x, y, z]))
        assert updates[-1].after == volume.distances[slot, z, y, x]
        assert updates[-1].weight == volume.weights[slot, z, y, x]
        assert updates[0].before is None
        measured += [one.measured for one in updates]
    assert min(measured) < 0.0 < max(measured) <= config.band
    assert why_surface(now, np.array([5, 5, 5])) == []


def test_a_line_of_sight_ends_at_the_surface() -> None:
    now = ReplayedSurface(images(), CONFIG)
    now.go_to(3)
    place = first_surface(now.volume, (0.1, 0.02, 0.03), (1.0, 0.0, 0.0))
    assert place is not None
    np.testing.assert_allclose(place, [2.0, 0.02, 0.03], atol=0.006)
    assert first_surface(now.volume, (0.1, 0.0, 0.0), (-1.0, 0.0, 0.0)) is None
    assert first_surface(now.volume, (4.0, 0.0, 0.0), (-1.0, 0.0, 0.0)) is None  # from behind
    assert first_surface(now.volume, (0.0, 0.0, 0.0), (np.nan, 0.0, 0.0)) is None


def test_too_many_pixels_are_thinned_and_the_camera_with_them() -> None:
    source = images(4).depth
    assert source is not None
    kept = GatheredDepth(CAMERA, 0.001, most=3 * 60 * 80)
    for k, pose in enumerate(source.poses):
        kept.add(np.where(source.depth(k) > 0, source.depth(k), np.nan), pose)
    thin = kept.sequence(np.array([0.5, 0.0, 0.0]))
    assert thin.images.shape == (4, 30, 40)
    assert "one of 2 rows" in kept.notes[0]
    half = thin.camera.points(thin.depth(3)).reshape(30, 40, 3)
    np.testing.assert_allclose(half, CAMERA.points(source.depth(3)).reshape(60, 80, 3)[::2, ::2])
    np.testing.assert_allclose(thin.poses[:, :3, 3], source.poses[:, :3, 3] - [0.5, 0.0, 0.0])


def test_without_the_place_of_the_sensor_there_is_no_surface() -> None:
    source = without_images(images(2))
    source.origins[:] = np.nan
    with pytest.raises(ConfigError, match="does not say where the sensor was"):
        ReplayedSurface(source, CONFIG)


@pytest.mark.parametrize("axis", UPS)
def test_turned_scans_have_the_same_surface_turned(axis: str) -> None:
    source = images(2)
    turn = np.array(UPS[axis], dtype=np.float64)
    assert np.linalg.det(turn) == pytest.approx(1.0)
    signs = {"-": -1.0}
    up = np.zeros(3)
    up["xyz".index(axis[-1])] = signs.get(axis[0], 1.0)
    np.testing.assert_array_equal(turn @ up, [0.0, 0.0, 1.0])
    turned = source.with_up(axis)
    np.testing.assert_allclose(turned.points, source.points @ turn.T.astype(np.float32))
    now = ReplayedSurface(turned, CONFIG)
    now.go_to(1)
    place = first_surface(now.volume, turn @ [0.1, 0.02, 0.03], turn @ [1.0, 0.0, 0.0])
    assert place is not None
    np.testing.assert_allclose(turn.T @ place, [2.0, 0.02, 0.03], atol=0.006)


def test_another_axis_than_three_cannot_point_up() -> None:
    with pytest.raises(ConfigError, match=r"one of z, -z, y, -y, x, -x, not 'w'"):
        images(2).with_up("w")
