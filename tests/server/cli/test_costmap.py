"""``gridbloom costmap``: the raw costs as a picture that another reader reads."""

import json
from pathlib import Path

import numpy as np
from PIL import Image

from mapper.costmap import cost_of_distance
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.io.maps import save_map
from tests.server.cli.running import Run

PARAMS = """
global_costmap:
  global_costmap:
    ros__parameters:
      robot_radius: 0.2
      footprint_padding: 0.0
      track_unknown_space: true
      plugins: [static_layer, inflation_layer]
      static_layer: {plugin: "nav2_costmap_2d::StaticLayer"}
      inflation_layer: {plugin: "nav2_costmap_2d::InflationLayer", inflation_radius: 1.0, cost_scaling_factor: 2.0}
"""


def small_map(folder: Path) -> Path:
    """A map of 30 × 40 free cells of 0.1 m with one wall cell, and unknown cells in the last column."""
    grid = OccupancyGrid(GridGeometry(0.1, 30, 40, (-1.0, 2.0, 0.0)))
    grid.log_odds[:] = -2.0
    grid.observed[:] = True
    grid.log_odds[10, 20] = 3.5
    grid.observed[:, -1] = False
    return save_map(grid, folder / "room")[0]


def test_the_pixels_are_nav2s_costs(run: Run, tmp_path: Path) -> None:
    yaml_path = small_map(tmp_path)
    params = tmp_path / "nav2.yaml"
    params.write_text(PARAMS)
    status, out, err = run("costmap", yaml_path, "--params", params, "--out", tmp_path / "costs", "--json")
    assert status == 0, err
    facts = json.loads(out)
    assert (facts["lethal"], facts["no_information"]) == (1, 30)
    with Image.open(tmp_path / "costs.pgm") as image:
        costs = np.flipud(np.asarray(image))
    assert costs[10, 20] == 254
    inscribed = 0.2 * np.cos(np.pi / 16)
    for cells in range(1, 11):
        assert costs[10, 20 + cells] == cost_of_distance(cells * 0.1, inscribed, 2.0)
    assert costs[10, 31] == 0
    assert costs[10, 39] == 255
    assert "origin: [-1.0, 2.0, 0.0]" in (tmp_path / "costs.yaml").read_text()


def test_a_bad_parameter_file_is_one_sentence(run: Run, tmp_path: Path) -> None:
    yaml_path = small_map(tmp_path)
    params = tmp_path / "nav2.yaml"
    params.write_text(PARAMS.replace("inflation_radius: 1.0", "inflation_radius: -1.0"))
    done = run("costmap", yaml_path, "--params", params, "--out", tmp_path / "costs")
    assert done.status == 2
    assert "inflation_layer.inflation_radius" in done.err
    assert not (tmp_path / "costs.pgm").exists()
    missing = run("costmap", yaml_path, "--params", tmp_path / "none.yaml", "--out", tmp_path / "costs")
    assert missing.status == 2
    assert "Traceback" not in missing.err
