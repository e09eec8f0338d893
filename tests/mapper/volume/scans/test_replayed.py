"""Sequences of scans: gathered, mapped up to any scan, and asked why a voxel is so."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import LimitError, MapperError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.clouds.depth_archive import unpack_depth_archive
from mapper.volume import OccupancyVolume, VolumeConfig
from mapper.volume.occupancy.provenance import why_voxel
from mapper.volume.occupancy.volume import keys_of
from mapper.volume.scans.replayed import ReplayedVolume
from mapper.volume.scans.scan_sequence import ScanSequence, first_in_cubes, gather
from tests.mapper.io.clouds.test_depth_folder import seven_scenes, tum


def sequence(n: int = 6, beams: int = 300) -> ScanSequence:
    """Scans of a room with a box in it that is taken away half-way, from a sensor that moves."""
    rng = np.random.default_rng(4)
    origins = np.column_stack([np.linspace(-1.0, 1.0, n), np.zeros(n), np.zeros(n)])
    scans = []
    for k, origin in enumerate(origins):
        away = rng.normal(size=(beams, 3))
        ranges = np.min(np.where(away > 0, np.array([3.0, 2.5, 1.5]) - origin, np.array([3.0, 2.5, 1.5]) + origin)
                        / np.abs(away), axis=1)  # fmt: skip
        away *= ranges[:, None]
        scans.append((origin + away * (0.5 if k < n // 2 else 1.0)).astype(np.float32))
    starts = np.cumsum([0, *map(len, scans)])
    stamps = (np.arange(n) + 1) * 1_000_000_000
    return ScanSequence("test", np.concatenate(scans), starts, origins, stamps, np.zeros(3))


@pytest.mark.parametrize("half_life", [0.0, 4.0])
@pytest.mark.parametrize("discretise", [True, False])
def test_what_scans_did_to_a_voxel_sums_up_to_the_map(half_life: float, discretise: bool) -> None:
    scans = sequence()
    config = VolumeConfig(resolution=0.25, half_life=half_life, discretise=discretise, range_max=2.4)
    replayed = ReplayedVolume(scans, config)
    assert replayed.go_to(len(scans))
    keys, values = replayed.volume.voxels()
    rng = np.random.default_rng(1)
    some = rng.choice(len(keys), 60, replace=False)
    hits = 0
    for key, value in zip(keys[some], values[some], strict=True):
        updates = why_voxel(map(scans.scan, range(len(scans))), config, key)
        after = updates[-1].after
        if half_life:
            after *= 0.5 ** ((len(scans) - 1 - updates[-1].scan) / half_life)
        assert after == pytest.approx(value, abs=2e-6)
        for one in updates:
            assert one.beams == len(one.ends) > 0
            if one.is_hit:
                assert (keys_of(one.ends, config.resolution)[0] == key).all()
        hits += sum(one.is_hit for one in updates)
    assert hits
    unknown = np.array([40000, 40000, 40000])
    assert why_voxel(map(scans.scan, range(len(scans))), config, unknown) == []


def test_going_back_gives_the_map_of_fewer_scans() -> None:
    scans = sequence()
    config = VolumeConfig(resolution=0.25)
    replayed = ReplayedVolume(scans, config)
    assert not replayed.go_to(5, is_over=lambda: True)
    assert replayed.index == 1
    replayed.go_to(5)
    replayed.take_touched()
    replayed.go_to(6)
    touched = replayed.take_touched()
    assert touched is not None
    assert len(touched)
    replayed.go_to(2)
    assert replayed.take_touched() is None
    expected = OccupancyVolume(config)
    for k in range(2):
        scan = scans.scan(k)
        expected.insert_scan(scan.points, scan.origin)
    (keys, values), (own_keys, own_values) = expected.voxels(), replayed.volume.voxels()
    order, own = np.lexsort(keys.T), np.lexsort(own_keys.T)
    np.testing.assert_array_equal(keys[order], own_keys[own])
    np.testing.assert_array_equal(values[order], own_values[own])


def test_a_map_that_needs_too_much_memory_is_refused_and_begun_anew() -> None:
    replayed = ReplayedVolume(sequence(), VolumeConfig(resolution=0.02), lambda: Limits(max_blocks=100))
    with pytest.raises(LimitError, match="more than 100"):
        replayed.go_to(6)
    assert (replayed.index, replayed.volume.n_known) == (0, 0)


def test_of_many_points_one_is_kept_in_each_cube_and_the_coarser_map_is_the_same(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    points = rng.normal(size=(5000, 3)).astype(np.float32)
    kept = points[first_in_cubes(points, 0.1)]
    cubes = np.unique(np.floor(points.astype(np.float64) / 0.1), axis=0)
    assert len(kept) == len(cubes) < len(points)
    path = tmp_path / "a.xyz"
    np.savetxt(path, points, fmt="%.4f")
    whole, part = gather(path), gather(path, most=3000)
    assert len(whole.points) == 5000
    assert len(part.points) <= 3000
    assert "one in each cube of" in part.notes[-1]


def test_coordinates_of_a_map_projection_are_moved_to_the_origin(tmp_path: Path) -> None:
    path = tmp_path / "utm.xyz"
    points = np.array([512_743.63, 5_403_547.33, 308.68]) + np.random.default_rng(1).uniform(0, 50, (200, 3))
    np.savetxt(path, points, fmt="%.2f")
    scans = gather(path)
    np.testing.assert_allclose(scans.points + scans.offset, points, atol=0.01)
    assert np.abs(scans.points).max() < 100
    assert any("The map’s origin is at 512,800, 5,403,600, 300 m" in note for note in scans.notes)


def zipped(folder: Path, into: Path, prefix: str = "") -> Path:
    with zipfile.ZipFile(into, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(folder.rglob("*")):
            archive.write(file, prefix + str(file.relative_to(folder)))
    return into


@pytest.mark.parametrize("make", [seven_scenes, tum])
def test_a_zip_of_a_depth_folder_is_the_folder(make, tmp_path: Path) -> None:
    folder, out = tmp_path / "room", tmp_path / "out"
    folder.mkdir()
    out.mkdir()
    make(folder)
    path = zipped(folder, tmp_path / "a.zip", "some/where/")
    unpack_depth_archive(path, out, DEFAULT_LIMITS)
    there, expected = gather(out), gather(folder)
    np.testing.assert_array_equal(there.points, expected.points)
    np.testing.assert_array_equal(there.origins, expected.origins)


def test_a_zip_writes_no_file_outside_and_none_too_large(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("../../evil.depth.png", b"a")
        archive.writestr("/etc/evil.pose.txt", b"a")
        archive.writestr("a.depth.png", bytes(3_000_000))
    with pytest.raises(LimitError, match="more than 2,000,000 bytes together, at"):
        unpack_depth_archive(path, out, Limits(max_unpacked_bytes=2_000_000))
    assert {one.name for one in tmp_path.iterdir()} == {"out", "a.zip"}
    for data in (b"PK\x03\x04" + bytes(50), path.read_bytes()[:-30]):
        path.write_bytes(data)
        with pytest.raises(ReadError, match=r"damaged, ends early, or is encrypted\."):
            unpack_depth_archive(path, out, DEFAULT_LIMITS)
    for method in (zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2):
        with zipfile.ZipFile(path, "w", method) as archive:
            archive.writestr("a.depth.png", np.random.default_rng(1).bytes(3000))
        (into := tmp_path / f"method {method}").mkdir()
        damaged = bytearray(path.read_bytes())
        damaged[60:1500] = bytes(1440)
        path.write_bytes(damaged)
        with pytest.raises(ReadError, match=r"damaged, ends early, or is encrypted\."):
            unpack_depth_archive(path, into, DEFAULT_LIMITS)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("holiday.jpg", b"a")
    with pytest.raises(MapperError, match="holds no folder of depth images"):
        unpack_depth_archive(path, out, DEFAULT_LIMITS)
