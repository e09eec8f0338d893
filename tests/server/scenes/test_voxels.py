"""Chunks of voxels: their bytes as a plain reader takes them, and that only changed ones are sent."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mapper.volume.mesh.faces import CENTRE
from mapper.volume.mesh.textbook import linear_of
from server.scenes.voxel_chunk import face_colors, voxel_chunk
from server.sessions.drawings import Voxels
from tests.server.scenes.conftest import Service
from tests.server.scenes.test_drawings import named, showing
from tests.server.scenes.voxel_world import PALETTE, SIZE, STEPS, blocks_world, read_chunk, seen_from_inside


def test_a_chunk_has_the_faces_of_its_voxels_in_their_colours() -> None:
    rng = np.random.default_rng(3)
    occupied = {(x, y, z) for x, y, z in rng.integers(0, 32, (60, 3)).tolist()} | {(31, 31, 31)}
    (quads,) = blocks_world(*((one, (one[0] + 1, one[1] + 1, one[2] + 1)) for one in sorted(occupied))).chunks.values()
    read = list(read_chunk(voxel_chunk(quads, face_colors(PALETTE))))
    assert [place for place, *_ in read] == sorted(occupied, key=lambda place: place[::-1])
    for place, sides, number, _ in read:
        beside = [tuple(np.add(place, step).tolist()) for step in STEPS]
        assert sides == [side for side in range(6) if beside[side] not in occupied]
        assert number == (0 if place[2] < 4 else 1)  # bands of 2 m, voxels of 0.5 m


def test_voxels_within_others_are_not_in_a_chunk() -> None:
    faces = blocks_world(((1, 2, 3), (9, 8, 12)))
    (quads,) = faces.chunks.values()
    read = list(read_chunk(voxel_chunk(quads, face_colors(PALETTE))))
    assert len(read) == 8 * 6 * 9 - 6 * 4 * 7
    assert sum(len(sides) for _, sides, *_ in read) == 2 * (8 * 6 + 8 * 9 + 6 * 9)


def test_faces_towards_unknown_space_are_not_in_a_chunk() -> None:
    volume, faces = seen_from_inside(np.random.default_rng(0), 4000)
    read = [
        (32 * np.array(key) + place, sides)
        for key, quads in faces.chunks.items()
        for place, sides, *_ in read_chunk(voxel_chunk(quads, face_colors(PALETTE)))
    ]
    assert len(read) > 500
    beside = volume.log_odds_of(np.array([[key + step for step in STEPS] for key, _ in read]).reshape(-1, 3))
    for (_, sides), values in zip(read, beside.reshape(-1, 6), strict=True):
        assert sides == np.flatnonzero(values < volume.config.log_odds_occupied).tolist()


def test_the_table_has_the_colour_of_each_side_and_number() -> None:
    palette = np.random.default_rng(1).integers(0, 256, (7, 3), dtype=np.uint8)
    table = face_colors(palette)
    assert table.shape == (6, 7, 3)
    # Faces upwards have the palette's colour as it is; those downwards are the darkest.
    np.testing.assert_array_equal(table[5], np.round(255.0 * linear_of(palette)))
    assert (table[4] == table.min(axis=0)).all()


def test_voxels_of_many_heights_have_the_colours_of_their_sides() -> None:
    palette = np.random.default_rng(1).integers(1, 256, (6, 3), dtype=np.uint8)
    faces = blocks_world(((0, 0, 0), (2, 2, 32)), colours=9)
    (quads,) = faces.chunks.values()
    assert quads[:, 6].max() == 8
    numbers = {
        (number, table.shape)
        for _, _, number, table in read_chunk(voxel_chunk(quads, face_colors(palette, by_side=True)))
    }
    assert numbers == {(0, (6, 1, 3))}
    table = face_colors(palette, by_side=True)[:, 0]
    np.testing.assert_array_equal(table[5], np.round(255.0 * linear_of(palette[5:]))[0])
    assert (table > 0).any(axis=1).all()


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
