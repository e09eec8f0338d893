"""``gridbloom path``: a way around a wall, and what is refused."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.io.maps import save_map
from tests.server.cli.running import Run


def walled_map(folder: Path) -> Path:
    """A map of 60 × 60 free cells of 0.1 m, whose wall at x = 3 m leaves 2 m open at the top."""
    grid = OccupancyGrid(GridGeometry(0.1, 60, 60))
    grid.log_odds[:] = -2.0
    grid.observed[:] = True
    grid.log_odds[:40, 30] = 3.5
    return save_map(grid, folder / "room")[0]


def test_the_path_goes_around_the_wall(run: Run, tmp_path: Path) -> None:
    yaml_path, way = walled_map(tmp_path), tmp_path / "new" / "way.csv"
    status, out, err = run("path", yaml_path, "--from", "1,1", "--to", "5,1", "--out", way, "--json")
    assert status == 0, err
    facts = json.loads(out)
    points = np.loadtxt(way, delimiter=",", skiprows=1)
    assert facts["points"] == len(points)
    np.testing.assert_allclose(points[[0, -1]], [[1.0, 1.0], [5.0, 1.0]])
    assert facts["length"] == round(float(np.hypot(*np.diff(points, axis=0).T).sum()), 3)
    assert facts["length"] >= 2 * math.hypot(2.0, 3.0)  # around the end of the wall
    assert points[np.argmin(np.abs(points[:, 0] - 3.05)), 1] > 4.1  # not through it, nor where the robot touches it


def test_what_is_refused(run: Run, tmp_path: Path) -> None:
    yaml_path = walled_map(tmp_path)
    for options, said in (
        (
            ("--from", "1,1", "--to", "99,1"),
            "(99, 1) is outside the map, which goes from (0.05, 0.05) to (5.95, 5.95) m",
        ),
        (("--from", "3.05,1", "--to", "5,1"), "The robot cannot be at the start: its cell is lethal."),
        (("--from", "1", "--to", "5,1"), "--from needs two numbers"),
        (("--from", "1,1", "--to", "5,nan"), "The goal must be two finite numbers"),
        (("--from", "1,1", "--to", "5,1", "--tolerance", "-1"), "(tolerance) must be between 0 and 10 m"),
    ):
        done = run("path", yaml_path, *options)
        assert done.status == 2
        assert said in done.err
    done = run("path", yaml_path.with_suffix(".pgm"), "--from", "1,1", "--to", "5,1")
    assert done.status == 2
    assert "'room.pgm' is an image: choose the yaml that names it." in done.err
    near = run("path", yaml_path, "--from", "1,1", "--to", "3.05,1")
    assert near.status == 0
    assert "the nearest place to the goal" in near.out


def test_parameters_of_nav2_and_the_commands_own(run: Run, tmp_path: Path) -> None:
    yaml_path, params = walled_map(tmp_path), tmp_path / "nav2.yaml"
    params.write_text(
        "global_costmap: {ros__parameters: {robot_radius: 1.2, footprint_padding: 0.0, plugins: [static, inflation],\n"
        "  static: {plugin: 'nav2_costmap_2d::StaticLayer'},\n"
        "  inflation: {plugin: 'nav2_costmap_2d::InflationLayer', inflation_radius: 1.5}}}\n"
        "planner_server: {ros__parameters: {planner_plugins: [A],\n"
        "  A: {plugin: 'nav2_navfn_planner::NavfnPlanner', tolerance: 0.0}}}\n"
    )
    ends = "--from", "1,1", "--to", "3.5,1"
    refused = run("path", yaml_path, *ends, "--params", params)
    assert refused.status == 2
    assert "its cell is inscribed, and no cell within the tolerance of 0 m can be reached" in refused.err
    near = run("path", yaml_path, *ends, "--params", params, "--tolerance", "2", "--json")
    assert near.status == 0, near.err
    assert json.loads(near.out)["reaches_goal"] is False


MASK = (
    "image: mask.pgm\nmode: {mode}\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
    "free_thresh: 0.25\n"
)


def mask_of(folder: Path, mode: str, dark: int, bright: int) -> Path:
    """A mask whose cells from row 30 to 59, the upper half of the map, have one grey, the others another."""
    pixels = np.full((60, 60), bright, np.uint8)
    pixels[:30] = dark
    Image.fromarray(pixels).save(folder / "mask.pgm")
    path = folder / "mask.yaml"
    path.write_text(MASK.format(mode=mode))
    return path


def test_masks_of_speed_limits_change_the_time_and_not_the_path(run: Run, tmp_path: Path) -> None:
    """In each mode of map_server: raw 40, scale by the grey between the thresholds, trinary 100."""
    yaml_path = walled_map(tmp_path)
    ends = "--from", "1,1", "--to", "5,1", "--json"
    free = json.loads(run("path", yaml_path, *ends).out)
    assert free["travel_s"] == pytest.approx(free["length"] / 0.5, abs=1e-3)
    slow = {}
    # scale: a grey of 140 has the occupancy 0.451, which is (0.451 - 0.25) / 0.4 of 100: 50.
    for mode, dark, options, share in (
        ("raw", 40, (), 0.4),
        ("scale", 140, (), 0.5),
        ("trinary", 0, ("--speed-base", "150", "--speed-multiplier", "-1.25"), 0.25),
        ("raw", 20, ("--speed-absolute", "--speed-multiplier", "0.01"), 0.4),
    ):
        mask = mask_of(tmp_path, mode, dark, 0 if mode == "raw" else 254)
        facts = json.loads(run("path", yaml_path, *ends, "--speed", mask, *options).out)
        assert (facts["length"], facts["cost"]) == (free["length"], free["cost"])
        slow[share] = facts["travel_s"] - free["travel_s"]
        costs = json.loads(run("costmap", yaml_path, "--out", tmp_path / "costs", "--speed", mask, "--json").out)
        assert costs["speed_limited"] == 1800
    upper = slow[0.5] * 0.5  # m in the upper half: half the speed takes as long again
    for share, more in slow.items():
        assert more == pytest.approx(upper / 0.5 * (1 / share - 1), rel=1e-3)
    assert 3.0 < upper < free["length"]


def test_a_keepout_mask_closes_the_way(run: Run, tmp_path: Path) -> None:
    yaml_path = walled_map(tmp_path)
    mask = mask_of(tmp_path, "trinary", 0, 254)
    costs = run("costmap", yaml_path, "--out", tmp_path / "costs", "--keepout", mask, "--json")
    assert json.loads(costs.out)["lethal"] == 1800 + 30
    done = run("path", yaml_path, "--from", "1,1", "--to", "5,1", "--keepout", mask)
    assert done.status == 2
    assert "There is no path to the goal" in done.err


def test_parameters_without_effect_are_named_and_the_followers_speed_holds(run: Run, tmp_path: Path) -> None:
    yaml_path, params = walled_map(tmp_path), tmp_path / "nav2.yaml"
    params.write_text(
        "global_costmap: {ros__parameters: {update_frequency: 1.0, plugins: []}}\n"
        "controller_server: {ros__parameters: {controller_frequency: 20.0, controller_plugins: [F],\n"
        "  F: {plugin: RegulatedPurePursuitController, desired_linear_vel: 0.25, allow_reversing: true}}}\n"
    )
    facts = json.loads(run("path", yaml_path, "--from", "1,1", "--to", "2,1", "--params", params, "--json").out)
    assert facts["travel_s"] == pytest.approx(facts["length"] / 0.25, abs=0.01)
    assert facts["without_effect"] == [
        "global_costmap.update_frequency",
        "controller_server.F.allow_reversing",
        "controller_server.controller_frequency",
    ]


def test_bad_masks_are_refused_in_a_sentence(run: Run, tmp_path: Path) -> None:
    yaml_path, mask = walled_map(tmp_path), mask_of(tmp_path, "raw", 40, 0)
    good = mask.read_text()
    for text, options, said in (
        (good.replace("mode: raw", "mode: grey"), (), "mode"),
        (good.replace("resolution: 0.1", "resolution: -1"), (), "resolution"),
        (good.replace("mask.pgm", "none.pgm"), (), "none.pgm"),
        (good + "gridbloom_frame: odom\n", (), None),
        (good, ("--speed-base", "nan"), "base and multiplier must be finite numbers"),
    ):
        mask.write_text(text)
        for option in ("--speed", "--keepout") if not options else ("--speed",):
            done = run("path", yaml_path, "--from", "1,1", "--to", "2,1", option, mask, *options)
            if said is None:
                assert done.status == 0, done.err  # the map states no frame
                continue
            assert (done.status, done.out, done.err.count("\n")) == (2, "", 1)
            assert said in done.err
    missing = run("path", yaml_path, "--from", "1,1", "--to", "2,1", "--keepout", tmp_path / "no.yaml")
    assert (missing.status, "There is no file 'no.yaml'" in missing.err) == (2, True)
