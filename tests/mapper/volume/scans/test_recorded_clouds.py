"""Recordings written by rosbags and mcap, of real points that a moving sensor measures: clouds, depths, maps."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from mapper.io.clouds import open_posed_clouds, read_cloud
from mapper.volume import OccupancyVolume, VolumeConfig, read_octree
from server.cli import app
from tests.mapper.io.logs.recorded import KINDS
from tests.mapper.volume.moving_lidar import record
from tests.mapper.volume.voxel_values import log_odds_at

CONFIG = VolumeConfig(resolution=0.1)


@pytest.fixture(scope="module")
def room(data_file: Callable[[str], Path]) -> np.ndarray:
    """20,000 points of a real room."""
    points = read_cloud(data_file("pointclouds/room_scan1.pcd")).points
    points = np.asarray(points[np.isfinite(points).all(axis=1)])
    return np.asarray(points[np.random.default_rng(0).permutation(len(points))[:20_000]])


@pytest.mark.parametrize("kind", KINDS)
def test_points_of_every_layout_are_put_where_they_were(kind: str, room: np.ndarray, tmp_path: Path) -> None:
    """Beside the truth: with each point's time they are within millimetres, without it a decimetre off."""
    run = record(tmp_path, room, kind)
    errors = {
        deskew: [
            np.linalg.norm(posed.points_in_map() - true, axis=1)
            for posed, true in zip(open_posed_clouds(run.path, deskew=deskew), run.truth, strict=True)
        ]
        for deskew in (True, False)
    }
    shapes = [posed.cloud.shape for posed in open_posed_clouds(run.path)]
    assert [shape and shape[0] for shape in shapes] == [8, 1, 1, 4]
    for corrected, plain in zip(errors[True], errors[False], strict=True):
        assert np.quantile(corrected, 0.99) < 0.005
        assert np.mean(plain) > 0.1


def test_the_command_maps_a_bag_as_the_truth_is(room: np.ndarray, tmp_path: Path) -> None:
    run = record(tmp_path, room, "bag")
    out = tmp_path / "room.ot"
    done = CliRunner().invoke(app, ["map3d", str(run.path), "--resolution", "0.1", "--out", str(out), "--json"])
    assert done.exit_code == 0, done.output
    facts = json.loads(done.stdout)
    assert (facts["scans"], facts["points"], facts["left_out"]) == (4, 20_000, 0)
    expected = OccupancyVolume(CONFIG)
    for true, origin in zip(run.truth, run.origins, strict=True):
        expected.insert_scan(true, origin)
    ours, theirs = (
        {(x, y, z) for x, y, z in volume.voxels(0.0)[0]} for volume in (read_octree(out).tree.volume(CONFIG), expected)
    )
    assert len(ours & theirs) > 0.93 * len(ours | theirs)


def test_given_poses_are_of_the_clouds_and_a_recording_before_them_takes_none(room: np.ndarray, tmp_path: Path) -> None:
    run = record(tmp_path, room, "bag")
    stamp = next(iter(open_posed_clouds(run.path))).cloud.stamp_ns * 1e-9
    poses = tmp_path / "poses.tum"
    poses.write_text("".join(f"{stamp + t:.3f} {x} 0 0 0 0 0 1\n" for t, x in ((-0.1, 100), (0.2, 200))))
    clouds = [tmp_path / "a.xyz", tmp_path / "b.xyz"]
    for cloud in clouds:
        np.savetxt(cloud, np.array([[0.55, 0.05, 0.05], [0.75, 0.05, 0.05]]), fmt="%.3f")
    for more, out in (((), tmp_path / "a.ot"), (("--tsdf",), tmp_path / "a.ply")):
        arguments = ["map3d", str(run.path), *map(str, clouds), "--poses", str(poses), "--out", str(out), *more]
        done = CliRunner().invoke(app, [*arguments, "--resolution", "0.1"])
        assert done.exit_code == 0, done.output
    places = log_odds_at(
        read_octree(tmp_path / "a.ot").tree.volume(CONFIG), [[100.55, 0.05, 0.05], [200.75, 0.05, 0.05]]
    )
    assert (places > 0.0).all()
