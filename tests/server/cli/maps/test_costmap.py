"""``gridbloom costmap``: the raw costs as a picture that another reader reads."""

import json
from pathlib import Path

import numpy as np
import pytest
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


def test_unknown_cells_that_count_as_free_are_said(run: Run, tmp_path: Path) -> None:
    yaml_path = small_map(tmp_path)
    status, out, err = run("costmap", yaml_path, "--out", tmp_path / "costs")
    assert status == 0, err
    assert "30 cells are unknown in the map and count as free: track_unknown_space is off" in out


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


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("robot_radius: 0.2", 'footprint: "[[1, 1], [-1, -1], [1, 101]]"'),
         "global_costmap.footprint: The points of a footprint must be finite and within 100 m."),
        (("inflation_radius: 1.0", "inflation_radius: .nan"), "inflation_layer.inflation_radius: "),
        (("global_costmap:\n  global_costmap:", "other:\n  other:"), "has no costmap: no global_costmap or local"),
    ],
)  # fmt: skip
def test_parameters_that_are_impossible(run: Run, tmp_path: Path, change: tuple[str, str], said: str) -> None:
    yaml_path = small_map(tmp_path)
    params = tmp_path / "nav2.yaml"
    params.write_text(PARAMS.replace(*change))
    done = run("costmap", yaml_path, "--params", params, "--out", tmp_path / "costs")
    assert (done.status, done.out, done.err.count("\n")) == (2, "", 1)
    assert said in done.err
    assert not (tmp_path / "costs.pgm").exists()


MASKED = """
      filters: [zones]
      zones: {plugin: "nav2_costmap_2d::KeepoutFilter", filter_info_topic: "/info"}
info_server: {ros__parameters: {type: 0, filter_info_topic: "/info", mask_topic: "/mask"}}
mask_server: {ros__parameters: {topic_name: "/mask", yaml_filename: "mask.yaml"}}
"""


def masked(folder: Path, frame: str) -> Path:
    """Parameters with a mask of 2 × 2 cells of 0.7 m in a corner of the map, the upper right one lethal."""
    Image.fromarray(np.array([[0, 100], [0, 0]], dtype=np.uint8)).save(folder / "mask.pgm")
    (folder / "mask.yaml").write_text(
        "image: mask.pgm\nmode: raw\nresolution: 0.7\norigin: [-1, 2, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
        f"free_thresh: 0.25\ngridbloom_frame: {frame}\n"
    )
    params = folder / "nav2.yaml"
    params.write_text(PARAMS + MASKED.lstrip("\n"))
    return params


def test_a_mask_of_another_resolution_is_laid_over_the_map_and_one_of_another_frame_refused(
    run: Run, tmp_path: Path
) -> None:
    yaml_path = small_map(tmp_path)
    with yaml_path.open("a") as file:
        file.write("gridbloom_frame: map\n")
    params = masked(tmp_path, "map")
    done = run("costmap", yaml_path, "--params", params, "--out", tmp_path / "costs")
    assert done.status == 0, done.err
    with Image.open(tmp_path / "costs.pgm") as image:
        costs = np.flipud(np.asarray(image))
    lethal = costs == 254
    lethal[10, 20] = False  # the wall
    expected = np.zeros_like(lethal)
    expected[7:14, 7:14] = True
    np.testing.assert_array_equal(lethal, expected)
    # The path goes around the zone, too.
    ends = "--from", "-0.75,3.05", "--to", "0.95,3.05", "--json"
    around = json.loads(run("path", yaml_path, *ends, "--params", params).out)
    straight = json.loads(run("path", yaml_path, *ends).out)
    assert around["length"] > straight["length"] + 0.15

    for command in (("costmap", "--out", tmp_path / "other"), ("path", *ends)):
        refused = run(command[0], yaml_path, *command[1:], "--params", masked(tmp_path, "odom"))
        assert (refused.status, refused.out) == (2, "")
        assert "The mask 'mask.yaml' of zones is in the frame 'odom', the map in 'map'" in refused.err


def test_a_map_without_free_cells_has_costs_and_no_path(run: Run, tmp_path: Path) -> None:
    grid = OccupancyGrid(GridGeometry(0.1, 20, 20))
    grid.log_odds[:], grid.observed[:] = 3.5, True
    yaml_path = save_map(grid, tmp_path / "full")[0]
    done = run("costmap", yaml_path, "--out", tmp_path / "costs", "--json")
    assert (done.status, json.loads(done.out)["lethal"]) == (0, 400)
    path = run("path", yaml_path, "--from", "0.5,0.5", "--to", "1.5,1.5")
    assert path.status == 2
    assert "The robot cannot be at the start: its cell is lethal." in path.err
