"""Maps and files equal OctoMap's: leaf for leaf and byte for byte."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pyoctomap
import pytest

from mapper.core.parallel import single_threaded
from mapper.io.clouds import read_scan_graph
from mapper.volume import OccupancyVolume, Octree, VolumeConfig, cast, octree_file, read_octree, write_octree
from mapper.volume.occupancy import volume as occupancy_module
from mapper.volume.occupancy.queries import HIT
from tests.mapper.volume.peer import octomap_tree, room_scans, written

CONFIGS = {
    "points": VolumeConfig(resolution=0.07, discretise=False),
    "voxels": VolumeConfig(resolution=0.1),
    "cut": VolumeConfig(resolution=0.1, range_max=2.2),
    "cut points": VolumeConfig(resolution=0.05, range_max=1.7, discretise=False),
}


def volume_of(scans: list[tuple[np.ndarray, np.ndarray]], config: VolumeConfig) -> OccupancyVolume:
    volume = OccupancyVolume(config)
    for points, origin in scans:
        volume.insert_scan(points, origin)
    return volume


@pytest.mark.parametrize("config", CONFIGS.values(), ids=CONFIGS)
def test_trees_are_octomaps(config: VolumeConfig, tmp_path: Path) -> None:
    scans = room_scans()
    peer, tree = octomap_tree(scans, config), Octree.of(volume_of(scans, config))
    assert tree.n_nodes == peer.size()
    assert tree.n_leaves == peer.getNumLeafNodes()
    for kind in (".ot", ".bt"):
        assert octree_file(tree, kind, config).bytes() == written(peer, kind, tmp_path)


def test_real_scan_is_octomaps(data_file, tmp_path: Path) -> None:
    (scan,) = read_scan_graph(data_file("octomap/spherical_scan.graph"))
    config = VolumeConfig(resolution=0.1, discretise=False)
    scans = [(scan.points_in_map().astype(np.float32), scan.pose[:3, 3].astype(np.float32))]
    assert octree_file(Octree.of(volume_of(scans, config)), ".ot", config).bytes() == written(
        octomap_tree(scans, config), ".ot", tmp_path
    )


def test_threads_and_tiles_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    scans, config = room_scans(), CONFIGS["cut points"]
    monkeypatch.setattr(occupancy_module, "STEPS_A_THREAD", 1)
    monkeypatch.setattr(occupancy_module, "BLOCKS_A_THREAD", 1)
    expected = octree_file(Octree.of(volume_of(scans, config)), ".ot", config).bytes()
    with single_threaded():
        assert octree_file(Octree.of(volume_of(scans, config)), ".ot", config).bytes() == expected
    monkeypatch.setattr(occupancy_module, "_TILE_VOXELS", 1 << 14)
    assert octree_file(Octree.of(volume_of(scans, config)), ".ot", config).bytes() == expected


@pytest.mark.parametrize("range_max", [-1.0, 1.5])
@pytest.mark.parametrize("through_unknown", [True, False])
def test_casts_are_octomaps(through_unknown: bool, range_max: float) -> None:
    scans, config = room_scans(2), CONFIGS["voxels"]
    peer, volume = octomap_tree(scans, config), volume_of(scans, config)
    rng = np.random.default_rng(8)
    origins = rng.uniform([-1.5, -2.5, 0.3], [1.5, 2.5, 2.0], (300, 3)).astype(np.float32)
    directions = rng.normal(size=(300, 3)).astype(np.float32)
    casts = cast(volume, origins, directions, through_unknown=through_unknown, range_max=max(range_max, 0.0))
    hits = 0
    for i, (origin, direction) in enumerate(zip(origins.astype(float), directions.astype(float), strict=True)):
        end = np.zeros(3)
        hit = peer.castRay(origin, direction, end, ignoreUnknownCells=through_unknown, maxRange=range_max)
        assert hit == (casts.ends[i] == HIT)
        if hit:
            np.testing.assert_array_equal(end.astype(np.float32), casts.points[i])
            hits += 1
    assert hits > 5


def test_octomaps_files_are_written_as_they_were_read(tmp_path: Path) -> None:
    config = CONFIGS["voxels"]
    peer = octomap_tree(room_scans(1), config)
    for kind in (".ot", ".bt"):
        content = written(peer, kind, tmp_path)
        again = tmp_path / f"again{kind}"
        commented = re.sub(rb"(?m)^#$", b"# made by a test\n# res 5", content, count=1)
        again.write_bytes(commented)
        read = read_octree(again)
        write_octree(read, again)
        assert again.read_bytes() == commented
        assert read.tree.n_nodes == peer.size()
        back = octree_file(Octree.of(read.tree.volume(config)), kind, config)
        assert back.bytes() == content  # by way of the voxels, too


def test_octomap_reads_our_files(tmp_path: Path) -> None:
    config = CONFIGS["voxels"]
    tree = Octree.of(volume_of(room_scans(1), config))
    path = tmp_path / "ours.bt"
    write_octree(octree_file(tree, ".bt", config), path)
    peer = pyoctomap.OcTree(0.5)
    assert peer.readBinary(str(path))
    assert peer.getResolution() == config.resolution
    keys, depths, values = read_octree(path).tree.leaves()
    assert peer.getNumLeafNodes() == len(keys)
    sides = 2 ** (16 - depths.astype(int))
    centres = (keys - 32768 + sides[:, None] / 2) * config.resolution
    for centre, value in zip(centres[::97], values[::97], strict=True):
        assert peer.isNodeOccupied(peer.search(centre)) == (value > 0.0)
