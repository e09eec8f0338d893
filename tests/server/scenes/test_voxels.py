"""Chunks of voxels: their files as an independent reader of glTF takes them, and that only changed ones are sent."""

from __future__ import annotations

import io
import json
import struct
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from mapper.volume import OccupancyVolume, VolumeConfig
from mapper.volume.faces import CENTRE, VoxelFaces, chunks_of, face_rule
from server.scenes.voxel_glb import GROUP, chunk_glb, face_colors
from server.sessions.drawings import Voxels
from tests.server.scenes.conftest import Service
from tests.server.scenes.test_drawings import named, showing

SIZE = 0.5
PALETTE = np.array([(255, 0, 0), (0, 0, 255)], np.uint8)


def blocks_world(*boxes: tuple[tuple[int, int, int], tuple[int, int, int]]) -> VoxelFaces:
    """The faces of a map in which each box (low, high in voxels from 0, half-open) is occupied."""
    volume = OccupancyVolume(VolumeConfig(resolution=SIZE))
    for low, high in boxes:
        grid = np.stack(np.meshgrid(*map(np.arange, low, high), indexing="ij"), axis=-1).reshape(-1, 3)
        volume.insert_scan((grid + 0.5) * SIZE, None)
    faces = VoxelFaces()
    rule = face_rule(volume, -1e3, 1e3, base=0.0, band=2.0, colours=2)
    faces.update(volume, rule, chunks_of(volume))
    return faces


def test_a_chunks_file_has_the_surface_of_its_voxels() -> None:
    faces = blocks_world(((1, 2, 3), (5, 4, 8)))
    (quads,) = faces.chunks.values()
    mesh = trimesh.load_mesh(io.BytesIO(chunk_glb(quads, face_colors(PALETTE))), file_type="glb")
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    assert mesh.area == 2 * (4 * 2 + 4 * 5 + 2 * 5)
    assert mesh.volume == pytest.approx(4 * 2 * 5)  # faces are counter-clockwise from outside
    np.testing.assert_array_equal(mesh.bounds, [(1, 2, 3), (5, 4, 8)])
    # Of the four sides and the two ends, only the sides are in two bands of height.
    assert len(quads) == 4 * 2 + 2


def test_a_file_of_several_groups_of_rectangles_has_all_of_them_in_their_colours() -> None:
    corners = [(x, y, z) for x in range(0, 10, 2) for y in range(0, 8, 2) for z in range(0, 10, 2)]
    faces = blocks_world(*((corner, (corner[0] + 1, corner[1] + 1, corner[2] + 1)) for corner in corners))
    (quads,) = faces.chunks.values()
    assert len(quads) == 6 * len(corners)
    assert len(quads) > 4 * GROUP
    assert len(quads) % GROUP != 0
    data = chunk_glb(quads, face_colors(PALETTE))
    (length,) = struct.unpack_from("<I", data, 12)
    view = json.loads(data[20 : 20 + length])["bufferViews"][1]
    colors = np.frombuffer(data, np.uint8, view["byteLength"], 28 + length + view["byteOffset"]).reshape(-1, 4)
    mesh = trimesh.load_mesh(io.BytesIO(data), file_type="glb", process=False)
    is_high = mesh.triangles_center[:, 2] > 3.5  # bands of 2 m, voxels of 0.5 m
    for corner in range(3):
        shades = colors[mesh.faces[:, corner]]
        np.testing.assert_array_equal(shades[:, [0, 2]] > 0, np.stack([~is_high, is_high], axis=1))
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    assert sorted(one.bounds[0].tolist() for one in mesh.split()) == sorted(map(list, corners))
    assert mesh.area == pytest.approx(len(quads))
    assert mesh.volume == pytest.approx(len(corners))


async def test_only_a_changed_chunk_is_sent_and_the_old_one_is_removed_later(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    faces = blocks_world(((0, 0, 0), (40, 3, 3)), ((-20, 0, 0), (-10, 3, 3)))
    voxels = Voxels(name="map", label="Voxels", chunks=dict(faces.chunks), palette=PALETTE, size=SIZE, corner=CENTRE)
    async with showing(service, monkeypatch, voxels) as (shown, client):
        assert len(client.of_type("GlbMessage")) == len(faces.chunks) == 3
        places = {tuple(m["position"]) for m in client.of_type("SetPositionMessage") if m["name"].startswith("/map/")}
        assert places == {(-16.0, 0.0, 0.0), (16.0, 0.0, 0.0)}  # 0 is what a node has at first
        (first, *_) = sorted(faces.chunks)
        client.forget()
        changed = {**voxels.chunks, first: voxels.chunks[first][:3]}
        shown.show(replace(voxels, chunks=changed))
        new = await client.until(lambda message: message["type"] == "GlbMessage")
        old = "/map/" + "_".join(map(str, first)) + "_a"
        assert new["name"] == old[:-1] + "b"
        await client.until(named("RemoveSceneNodeMessage", old))
        assert len(client.of_type("GlbMessage")) == 1
        del changed[first]
        shown.show(replace(voxels, chunks=dict(changed)))
        await client.until(named("RemoveSceneNodeMessage", new["name"]))
