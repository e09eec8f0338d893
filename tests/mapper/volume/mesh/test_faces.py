"""Faces that a ray meets, and chunks that are made again after a change."""

from __future__ import annotations

import numpy as np

from mapper.volume import OccupancyVolume, VolumeConfig, cast
from mapper.volume.mesh.faces import CENTRE, CHUNK, VoxelFaces, chunks_of, face_rule, first_face, voxel_mesh
from mapper.volume.mesh.voxel_classes import voxel_classes

RESOLUTION = 0.25


def room() -> OccupancyVolume:
    """A box of 6 × 5 × 3 m, seen from inside."""
    rng = np.random.default_rng(2)
    away = rng.normal(size=(20_000, 3))
    ranges = np.min(np.array([3.0, 2.5, 1.5]) / np.abs(away), axis=1)
    volume = OccupancyVolume(VolumeConfig(resolution=RESOLUTION))
    volume.insert_scan(away * (ranges * 0.999)[:, None] + 0.02, np.full(3, 0.02))
    return volume


def test_a_ray_from_inside_meets_the_voxel_that_a_cast_meets_and_one_from_outside_looks_into_the_room() -> None:
    volume = room()
    rule = face_rule(volume, -9.0, 9.0, base=0.0, band=1.0, colours=4, seen_only=True)
    rng = np.random.default_rng(3)
    away = rng.normal(size=(40, 3)).astype(np.float32)
    inside = np.full(3, 0.02, np.float32)
    casts = cast(volume, np.tile(inside, (40, 1)), away)
    assert [first_face(volume, rule, inside, one) for one in away] == [tuple(key) for key in casts.keys.tolist()]
    # From outside, the near wall shows its unseen back: the far wall is what is drawn there.
    eye, ahead = np.array([0.1, -20.0, 0.1]), np.array([0.0, 1.0, 0.0])
    _, y, _ = first_face(volume, rule, eye, ahead) or (0, 0, 0)
    assert (y - CENTRE + 0.5) * RESOLUTION > 2.0
    whole = rule._replace(seen_only=False)
    _, y, _ = first_face(volume, whole, eye, ahead) or (0, 0, 0)
    assert (y - CENTRE + 0.5) * RESOLUTION < -2.0
    # A cut is looked through, and what it shows of a wall is met from above.
    cut = face_rule(volume, -9.0, 0.5, base=0.0, band=1.0, colours=4, seen_only=True)
    found = first_face(volume, cut, np.array([0.1, 2.55, 9.0]), np.array([0.0, 0.0, -1.0]))
    assert found is not None
    assert (found[2] - CENTRE + 0.5) * RESOLUTION <= 0.5
    assert first_face(volume, rule, eye, -ahead) is None


def test_only_the_chunks_of_changed_blocks_are_made_again_and_neighbours_of_a_border() -> None:
    volume = room()
    rule = face_rule(volume, -9.0, 9.0, base=0.0, band=1.0, colours=4)
    faces = VoxelFaces()
    faces.update(volume, rule, chunks_of(volume))
    before = dict(faces.chunks)
    did = volume.insert_scan([[0.1, 0.1, 0.1]], None)  # the first voxel of a chunk
    touched = chunks_of(volume, did.slots)
    corner = CENTRE // CHUNK
    assert set(touched) == {(corner - i, corner - j, corner - k) for i in (0, 1) for j in (0, 1) for k in (0, 1)}
    assert faces.update(volume, rule, touched) == [(corner, corner, corner)]
    again = VoxelFaces()
    again.update(volume, rule, chunks_of(volume))
    assert again.chunks.keys() == faces.chunks.keys()
    for key, quads in again.chunks.items():
        np.testing.assert_array_equal(quads, faces.chunks[key])
        assert (faces.chunks[key] is before[key]) == (key != (corner, corner, corner))


def test_the_mesh_of_a_map_is_closed_and_of_the_voxels_volume() -> None:
    volume = room()
    mesh = voxel_mesh(volume)
    a, b, c = (mesh.vertices[mesh.triangles[:, k]].astype(np.float64) for k in range(3))
    enclosed = float((a * np.cross(b, c)).sum()) / 6.0  # by the divergence theorem
    occupied, _ = volume.count_states()
    np.testing.assert_allclose(enclosed, occupied * RESOLUTION**3, rtol=1e-5)
    np.testing.assert_array_equal(np.sign(np.cross(b - a, c - a)), mesh.normals[mesh.triangles[:, 0]])


def test_voxels_have_the_colour_of_the_commonest_class_of_their_points() -> None:
    rng = np.random.default_rng(6)
    points = rng.uniform(-12.0, 12.0, (4000, 3)).astype(np.float32)
    classes = rng.integers(-1, 14, 4000)
    resolution, most = 2.0, 12
    counts: dict[tuple[int, ...], list[int]] = {}
    for point, kind in zip(points, classes, strict=True):
        key = tuple(int(k) for k in np.floor(point / resolution).astype(int) + CENTRE)
        counts.setdefault(key, [0] * most)[min(max(int(kind), 0), most - 1)] += 1
    painted = voxel_classes(points, classes, resolution, most)
    found = {}
    for chunk, (places, colours) in painted.items():
        for place, colour in zip(places.tolist(), colours.tolist(), strict=True):
            x, y, z = place % CHUNK, place // CHUNK % CHUNK, place // CHUNK**2
            found[chunk[0] * CHUNK + x, chunk[1] * CHUNK + y, chunk[2] * CHUNK + z] = colour
    assert found == {key: 1 + of.index(max(of)) for key, of in counts.items()}
    # A voxel alone is drawn in its colour; one of which nothing is known in the first.
    volume = OccupancyVolume(VolumeConfig(resolution=resolution))
    volume.insert_scan([[1.0, 1.0, 1.0], [9.0, 1.0, 1.0]], None)
    faces = VoxelFaces()
    rule = face_rule(volume, -99.0, 99.0, base=0.0, band=1.0, colours=24)
    one = voxel_classes(np.ones((3, 3), np.float32), np.array([6, 2, 6]), resolution, most)
    faces.update(volume, rule, chunks_of(volume), painted=one)
    (quads,) = faces.chunks.values()
    assert {(int(q[1]), int(q[6])) for q in quads} == {(0, 7), (4, 1)}
