"""``gridbloom terrain``: ground points, classes as a map, the comparison with points that are known to be ground."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from mapper.io.maps import load_map
from tests.server.cli.running import Run


def write(path: Path, points: np.ndarray) -> Path:
    np.savetxt(path, points, fmt="%.3f")
    return path


def test_a_wall_on_a_floor(run: Run, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform(0.0, 20.0, (4000, 3)) * (1.0, 1.0, 0.0)
    wall = (points[:, 0] > 8.0) & (points[:, 0] < 10.0)
    points[wall, 2] = 2.0
    cloud, truth = write(tmp_path / "a.xyz", points), write(tmp_path / "ground.xyz", points[~wall])
    status, said, err = run("terrain", cloud, "--out", tmp_path / "out", "--truth", truth, "--json")
    assert status == 0, err
    facts = json.loads(said)
    assert (facts["points"], facts["ground"], facts["kappa"]) == (4000, int((~wall).sum()), 100.0)
    ground = np.load(tmp_path / "out.npy")
    assert ground.dtype == np.uint8
    np.testing.assert_array_equal(ground, ~wall)
    grid = load_map(tmp_path / "out.yaml").grid
    (free, occupied) = grid.geometry.world_to_cell([[2.5, 10.5], [9.0, 10.5]])
    assert grid.log_odds[tuple(free)] < 0.0 < grid.log_odds[tuple(occupied)]
    assert "100.0 %" in run("terrain", cloud, "--out", tmp_path / "out", "--truth", truth).out


def test_many_unknown_patches_are_said_with_what_helps(run: Run, tmp_path: Path) -> None:
    x, y = np.meshgrid(np.arange(0.25, 20.0, 0.5), np.arange(0.25, 20.0, 0.5))
    cloud = write(tmp_path / "a.xyz", np.column_stack([x.ravel(), y.ravel(), 0.0 * x.ravel()]))
    out = ("--out", tmp_path / "out")
    assert "1600 of the 1600 patches with points are unknown" in run("terrain", cloud, *out, "--patch", "0.5").out
    facts = json.loads(run("terrain", cloud, *out, "--patch", "0.5", "--json").out)
    assert facts["unknown"] == 1600
    assert any("--patch" in note for note in facts["notes"])
    said = run("terrain", cloud, *out, "--patch", "2").out
    assert "100 safe, 0 unsafe, 0 unknown" in said
    assert "--patch" not in said


def test_bad_input_is_one_sentence(run: Run, tmp_path: Path) -> None:
    cloud = write(tmp_path / "a.xyz", np.zeros((5, 3)))
    far = write(tmp_path / "far.xyz", np.array([[0.0, 0.0, 0.0], [1e7, 1e7, 0.0]]))
    other = write(tmp_path / "other.xyz", np.ones((5, 3)))
    out = ("--out", tmp_path / "out")
    for arguments, said in (
        ((tmp_path / "none.pcd", *out), "There is no file 'none.pcd'"),
        ((far, *out), "choose larger cells, or leave out points that are far"),
        ((cloud, *out, "--cell", "0"), "(cell) must be between 0.05 and 20 m"),
        ((cloud, *out, "--truth", other), "None of its points is a point of the cloud"),
    ):
        status, _, err = run("terrain", *arguments)
        assert status == 2
        assert said in err
        assert err.count("\n") == 1
    assert not (tmp_path / "out.npy").exists()
