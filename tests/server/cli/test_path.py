"""``gridbloom path``: a way around a wall, and what is refused."""

import json
import math
from pathlib import Path

import numpy as np

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
    yaml_path = walled_map(tmp_path)
    status, out, err = run("path", yaml_path, "--from", "1,1", "--to", "5,1", "--out", tmp_path / "way.csv", "--json")
    assert status == 0, err
    facts = json.loads(out)
    points = np.loadtxt(tmp_path / "way.csv", delimiter=",", skiprows=1)
    assert facts["points"] == len(points)
    np.testing.assert_allclose(points[[0, -1]], [[1.0, 1.0], [5.0, 1.0]])
    assert facts["length"] == round(float(np.hypot(*np.diff(points, axis=0).T).sum()), 3)
    assert facts["length"] >= 2 * math.hypot(2.0, 3.0)  # around the end of the wall
    assert points[np.argmin(np.abs(points[:, 0] - 3.05)), 1] > 4.1  # not through it, nor where the robot touches it


def test_what_is_refused(run: Run, tmp_path: Path) -> None:
    yaml_path = walled_map(tmp_path)
    for options, said in (
        (("--from", "1,1", "--to", "99,1"), "The goal (99, 1) is outside the map"),
        (("--from", "3.05,1", "--to", "5,1"), "The robot cannot be at the start: its cell is lethal."),
        (("--from", "1", "--to", "5,1"), "--from needs two numbers"),
        (("--from", "1,1", "--to", "5,nan"), "The goal must be two finite numbers"),
        (("--from", "1,1", "--to", "5,1", "--tolerance", "-1"), "(tolerance) must be between 0 and 10 m"),
    ):
        done = run("path", yaml_path, *options)
        assert done.status == 2
        assert said in done.err
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
