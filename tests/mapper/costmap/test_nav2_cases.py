"""Costs cell for cell in tables of cases that were worked out by hand from Nav2's documentation.

Sources: the Nav2 documentation, Costmap 2D with its plugins and Map Server; nav2_map_server, map_io.cpp;
nav2_costmap_2d, static_layer.cpp, costmap_layer.cpp, inflation_layer.cpp, obstacle_layer.cpp, costmap_2d.hpp,
keepout_filter.cpp, speed_filter.cpp.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from mapper.costmap import (
    CostmapConfig,
    Footprint,
    InflationConfig,
    KeepoutLayer,
    LayeredCostmap,
    Mask,
    Observation,
    ObstacleConfig,
    ObstacleLayer,
    SpeedFilter,
    StaticConfig,
    StaticLayer,
)
from mapper.costmap.inflation import inflate
from mapper.costmap.kernels.observation import lay_over
from mapper.costmap.layers import Robot
from mapper.costmap.nav2.reading import parse_nav2_costmap
from mapper.grid import GridGeometry
from mapper.io.maps import load_map

U = 255  #: no information
THRESHOLDS = "occupied_thresh: 0.65\nfree_thresh: 0.196\n"

#: mode, negate, greys of an image's row, values of the map. Occupancy is (255 − grey) / 255, or grey / 255 negated.
MAP_SERVER_CASES: list[tuple[str, int, list[int], list[int]]] = [
    # 0.65 · 255 = 165.75: grey 89 is 166 / 255, 90 is 165 / 255. 0.196 · 255 = 49.98: grey 205 is 50 / 255.
    ("trinary", 0, [0, 89, 90, 204, 205, 206, 254, 255], [100, 100, -1, -1, -1, 0, 0, 0]),
    ("trinary", 1, [0, 49, 50, 165, 166, 255], [0, 0, -1, -1, 100, 100]),
    # Between the thresholds (occupancy − 0.196) / 0.454 · 100: 127 / 255 → 66.5, 51 / 255 → 0.9, 165 / 255 → 99.4.
    ("scale", 0, [0, 89, 90, 128, 204, 206, 255], [100, 100, 99, 67, 1, 0, 0]),
    ("scale", 1, [255, 165, 127, 51, 49, 0], [100, 99, 67, 1, 0, 0]),
    ("raw", 0, [0, 1, 50, 100, 101, 205, 255], [0, 1, 50, 100, -1, -1, -1]),
    ("raw", 1, [0, 1, 50, 100, 101, 205, 255], [0, 1, 50, 100, -1, -1, -1]),
]


@pytest.mark.parametrize(("mode", "negate", "greys", "expected"), MAP_SERVER_CASES)
def test_map_files_are_read_as_the_map_server_reads_them(
    tmp_path: Path, mode: str, negate: int, greys: list[int], expected: list[int]
) -> None:
    Image.fromarray(np.array([greys], np.uint8)).save(tmp_path / "map.pgm")
    about = f"image: map.pgm\nmode: {mode}\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: {negate}\n{THRESHOLDS}"
    (tmp_path / "map.yaml").write_text(about)
    assert load_map(tmp_path / "map.yaml").values.tolist() == [expected]


def test_a_transparent_pixel_is_unknown_in_mode_scale_and_averaged_in_mode_trinary(tmp_path: Path) -> None:
    pixels = np.array([[[0, 0, 0, 255], [0, 0, 0, 0], [255, 255, 255, 128]]], np.uint8)
    Image.fromarray(pixels, "RGBA").save(tmp_path / "map.png")
    # Trinary: the mean of the colours and the opacity: 255 / 4, 0 and 893 / 4 are occupied, occupied and free.
    for mode, expected in (("scale", [100, -1, -1]), ("trinary", [100, 100, 0])):
        about = f"image: map.png\nmode: {mode}\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n{THRESHOLDS}"
        (tmp_path / "map.yaml").write_text(about)
        assert load_map(tmp_path / "map.yaml").values.tolist() == [expected]


VALUES = [-1, 0, 1, 49, 50, 64, 65, 98, 99, 100]
#: parameters of the static layer, track_unknown_space, costs of the values above
STATIC_CASES: list[tuple[dict[str, Any], bool, list[int]]] = [
    ({}, True, [U, 0, 0, 0, 0, 0, 0, 0, 253, 254]),
    ({}, False, [0, 0, 0, 0, 0, 0, 0, 0, 253, 254]),
    ({"lethal_cost_threshold": 65}, True, [U, 0, 0, 0, 0, 0, 254, 254, 253, 254]),
    ({"lethal_cost_threshold": 1}, False, [0, 0, 254, 254, 254, 254, 254, 254, 253, 254]),
    # value / 100 · 254, cut: 2.54, 124.46, 127, 162.56, 165.1, 248.92
    ({"trinary_costmap": False}, True, [U, 0, 2, 124, 127, 162, 165, 248, 253, 254]),
    # value / 65 · 254, cut: 3.9, 191.4, 195.4, 250.1
    (
        {"trinary_costmap": False, "lethal_cost_threshold": 65},
        False,
        [0, 0, 3, 191, 195, 250, 254, 254, 253, 254],
    ),
    # Another value means unknown: −1 is 255 as a byte then, which is at least the threshold.
    ({"unknown_cost_value": 50}, True, [254, 0, 0, 0, U, 0, 0, 0, 253, 254]),
    ({"unknown_cost_value": 50}, False, [254, 0, 0, 0, 0, 0, 0, 0, 253, 254]),
    ({"unknown_cost_value": 99}, True, [254, 0, 0, 0, 0, 0, 0, 0, U, 254]),
    ({"inscribed_obstacle_cost_value": 64}, True, [U, 0, 0, 0, 0, 253, 0, 0, 0, 254]),
    (
        {"inscribed_obstacle_cost_value": 100, "trinary_costmap": False},
        True,
        [U, 0, 2, 124, 127, 162, 165, 248, 251, 253],
    ),
]  # fmt: skip


@pytest.mark.parametrize(("given", "tracks", "expected"), STATIC_CASES)
def test_the_static_layer_interprets_values(given: dict[str, Any], tracks: bool, expected: list[int]) -> None:
    geometry = GridGeometry(0.1, 1, len(VALUES))
    general = CostmapConfig(track_unknown_space=tracks)
    layer = StaticLayer(geometry, np.array([VALUES], np.int8), StaticConfig(**given), general)
    assert layer.costs.tolist() == [expected]
    lines = "".join(f"      {name}: {str(value).lower()}\n" for name, value in given.items())
    text = f"global_costmap:\n  ros__parameters:\n    plugins: [s]\n{lines.replace('      ', '    ')}"
    text += '    s: {plugin: "nav2_costmap_2d::StaticLayer"}\n'
    assert parse_nav2_costmap(text.encode()).layers[0].config == StaticConfig(**given)


OLD = [0, 0, 0, 100, 100, 100, 254, 254, U, U, U]
NEW = [0, 100, U, 0, 200, U, 100, U, 0, 100, U]
#: combination_method, costs after a layer NEW was laid over OLD
COMBINATION_CASES = [
    (0, [0, 100, 0, 0, 200, 100, 100, 254, 0, 100, U]),  # overwrite: what the layer knows
    (1, [0, 100, 0, 100, 200, 100, 254, 254, 0, 100, U]),  # the greater; known over unknown
    (2, [0, 100, 0, 100, 200, 100, 254, 254, U, U, U]),  # the greater; unknown of the master stays
    (3, NEW),  # the static layer without use_maximum
]


@pytest.mark.parametrize(("method", "expected"), COMBINATION_CASES)
def test_layers_are_combined(method: int, expected: list[int]) -> None:
    master = np.array([OLD], np.uint8)
    lay_over(np.array([NEW], np.uint8), method, master)
    assert master.tolist() == [expected]


#: Cells of 0.1 m, inscribed radius 0.1 m, scaling factor 5, radius 0.3 m: 253 at 0.1 m; 252 · e^−0.5 = 152.8 at 0.2 m;
#: 252 · e^−1 = 92.7 at 0.3 m; nothing farther away.
INFLATION_CASES: list[tuple[dict[str, bool], list[int], list[int]]] = [
    ({}, [254, 0, 0, 0, 0], [254, 253, 152, 92, 0]),
    ({}, [254, 0, 200, 50, 10], [254, 253, 200, 92, 10]),  # the greater cost holds
    ({}, [254, U, U, U, U], [254, 253, U, U, U]),  # only inscribed costs into the unknown
    ({"inflate_unknown": True}, [254, U, U, U, U], [254, 253, 152, 92, U]),
    ({}, [U, 0, 0, 0, 0], [U, 0, 0, 0, 0]),
    ({"inflate_around_unknown": True}, [U, 0, 0, 0, 0], [254, 253, 152, 92, 0]),
    ({"inflate_around_unknown": True, "inflate_unknown": True}, [U, 0, 0, 0, 0], [254, 253, 152, 92, 0]),
    ({}, [253, 0, 0, 0, 0], [253, 0, 0, 0, 0]),  # inscribed cells are not inflated
    ({"enabled": False}, [254, 0, 0, 0, 0], [254, 0, 0, 0, 0]),
]


@pytest.mark.parametrize(("given", "before", "after"), INFLATION_CASES)
def test_inflation_beside_known_and_unknown_cells(given: dict[str, bool], before: list[int], after: list[int]) -> None:
    config = InflationConfig(inflation_radius=0.3, cost_scaling_factor=5.0, **given)
    out = np.empty((1, 5), np.uint8)
    inflate(np.array([before], np.uint8), config, 0.1, 0.1, out)
    assert out.tolist() == [after]


def test_the_inscribed_radius_is_that_of_the_padded_footprint() -> None:
    """0.5 × 0.4 m with a padding of 0.01 m: 0.21 m to the sides, so 253 at 0.2 m and 252 · e^−0.9 = 102.4 at 0.3 m."""
    text = b"""
global_costmap:
  ros__parameters:
    footprint: "[[0.25, 0.2], [-0.25, 0.2], [-0.25, -0.2], [0.25, -0.2]]"
    plugins: [i]
    i: {plugin: "nav2_costmap_2d::InflationLayer", inflation_radius: 0.3}
"""
    outline = parse_nav2_costmap(text).outline
    assert outline.inscribed_radius == pytest.approx(0.21)
    assert outline.circumscribed_radius == pytest.approx(np.hypot(0.26, 0.21))
    out = np.empty((1, 5), np.uint8)
    config = InflationConfig(inflation_radius=0.3)
    inflate(np.array([[254, 0, 0, 0, 0]], np.uint8), config, 0.1, outline.inscribed_radius, out)
    assert out.tolist() == [[254, 253, 253, 102, 0]]


#: values of a keepout mask, costs over a free, a costly (100), a lethal and an unknown cell: round(value · 254 / 100),
#: and the greater holds. −1 changes nothing.
KEEPOUT_CASES = [
    (-1, [0, 100, 254, U]),
    (0, [0, 100, 254, 0]),
    (1, [3, 100, 254, 3]),
    (50, [127, 127, 254, 127]),
    (75, [191, 191, 254, 191]),  # 190.5 rounds away from zero
    (100, [254, 254, 254, 254]),
]


@pytest.mark.parametrize(("value", "expected"), KEEPOUT_CASES)
def test_a_keepout_mask_over_other_costs(value: int, expected: list[int]) -> None:
    geometry = GridGeometry(0.1, 1, 4)
    layer = KeepoutLayer(geometry, Mask(geometry, np.full((1, 4), value, np.int8)))
    box = layer.changed(0.0, None)
    master = np.array([[0, 100, 254, U]], np.uint8)
    assert box is not None
    layer.lay(master, box)
    assert master.tolist() == [expected]


GEOMETRY = GridGeometry(0.1, 7, 7)
ROBOT = Robot((0.35, 0.35, 0.0), Footprint(((0.14, 0.04), (-0.14, 0.04), (-0.14, -0.04), (0.14, -0.04))))
#: the robot covers the cells of row 3 from column 2 to 4
UNDER = (3, slice(2, 5))


@pytest.mark.parametrize("clears", [True, False])
def test_obstacles_under_the_robot(clears: bool) -> None:
    config = ObstacleConfig(footprint_clearing_enabled=clears)
    layer = ObstacleLayer(GEOMETRY, config, CostmapConfig())
    points = np.array([[x, y, 0.2] for y in (0.35, 0.55) for x in np.arange(0.05, 0.7, 0.1)])
    layer.observe(Observation(np.array([0.35, 0.05, 0.2]), points))
    before = layer.costs.copy()
    layer.changed(0.0, ROBOT)
    expected = before.copy()
    if clears:
        assert (before[UNDER] == 254).any()
        expected[UNDER] = 0
    np.testing.assert_array_equal(layer.costs, expected)


#: Parameters of the obstacle layer, distance of the one reading in cells of 1 m, and the cells of its row. A reading
#: marks if obstacle_min_range <= distance < obstacle_max_range. Its line is cleared from the cell at raytrace_min_range
#: to that at raytrace_max_range, in cells rounded up, both included; nothing where it ends before raytrace_min_range.
RANGE_CASES: list[tuple[dict[str, Any], float, list[int]]] = [
    ({}, 6, [0] * 6 + [254] + [U] * 5),
    ({"obstacle_max_range": 6.0}, 6, [0] * 7 + [U] * 5),
    ({"obstacle_max_range": 6.01}, 6, [0] * 6 + [254] + [U] * 5),
    ({"obstacle_min_range": 6.0}, 6, [0] * 6 + [254] + [U] * 5),
    ({"obstacle_min_range": 6.01}, 6, [0] * 7 + [U] * 5),
    ({"raytrace_max_range": 4.0}, 8, [0] * 5 + [U] * 3 + [254] + [U] * 3),
    ({"raytrace_max_range": 3.2}, 8, [0] * 5 + [U] * 3 + [254] + [U] * 3),
    ({"raytrace_min_range": 2.0}, 6, [U] * 2 + [0] * 4 + [254] + [U] * 5),
    ({"raytrace_min_range": 1.1}, 6, [U] * 2 + [0] * 4 + [254] + [U] * 5),
    ({"raytrace_min_range": 7.0}, 6, [U] * 6 + [254] + [U] * 5),
    ({"raytrace_min_range": 2.0, "raytrace_max_range": 6.0}, 10, [U] * 2 + [0] * 5 + [U] * 3 + [254, U]),
    ({"obstacle_max_range": 5.0, "raytrace_max_range": 5.0}, 10, [0] * 6 + [U] * 6),
    ({"clearing": False}, 6, [U] * 6 + [254] + [U] * 5),
    ({"marking": False}, 6, [0] * 7 + [U] * 5),
]  # fmt: skip


@pytest.mark.parametrize(("given", "distance", "expected"), RANGE_CASES)
def test_the_ranges_of_marking_and_clearing(given: dict[str, Any], distance: float, expected: list[int]) -> None:
    config = ObstacleConfig(**({"obstacle_max_range": 20.0, "raytrace_max_range": 20.0} | given))
    layer = ObstacleLayer(GridGeometry(1.0, 1, 12), config, CostmapConfig(track_unknown_space=True))
    layer.observe(Observation(np.array([0.5, 0.5, 0.1]), np.array([[0.5 + distance, 0.5, 0.1]])))
    assert layer.costs.tolist() == [expected]


#: Type, base, multiplier, value of the mask, and the greatest speed of a robot that drives 0.5 m/s without a limit.
SPEED_CASES: list[tuple[int, float, float, int, float]] = [
    (1, 100.0, -1.0, 40, 0.3),  # the tutorial's: 100 − 40 %
    (1, 0.0, 1.0, 40, 0.2),
    (1, 20.0, 0.5, 40, 0.2),
    (1, 100.0, -1.0, 0, 0.5),  # 0 is no limit, whatever the base
    (1, 100.0, -1.0, 100, 0.5),  # a limit of 0 is SPEED_LIMIT_NONE
    (1, 50.0, 1.0, 80, 0.5),  # 130 % is refused
    (1, -50.0, 1.0, 40, 0.5),  # −10 % is refused
    (2, 0.0, 0.01, 10, 0.1),
    (2, 0.1, 0.002, 50, 0.2),
    (2, 0.0, 0.02, 100, 0.5),  # faster than the robot
    (2, -1.0, 0.01, 50, 0.5),  # −0.5 m/s is refused
]


@pytest.mark.parametrize(("kind", "base", "multiplier", "value", "expected"), SPEED_CASES)
def test_speed_limits(kind: int, base: float, multiplier: float, value: int, expected: float) -> None:
    mask = Mask(GridGeometry(1.0, 1, 1), np.array([[value]], np.int8))
    assert SpeedFilter(mask, kind, base, multiplier).at(0.5, 0.5).of(0.5) == pytest.approx(expected)


def test_the_map_under_the_robot_is_free_while_it_is_there() -> None:
    """As footprint_clearing_enabled and restore_cleared_footprint of the static layer say."""
    general, values = CostmapConfig(), np.full(GEOMETRY.shape, 100, np.int8)
    layer = StaticLayer(GEOMETRY, values, StaticConfig(footprint_clearing_enabled=True), general)
    costmap = LayeredCostmap(GEOMETRY, general, ROBOT.footprint, [layer])
    for row in (3, 4):
        costmap.update(pose=(0.35, 0.05 + 0.1 * row, 0.0))
        expected = np.full(GEOMETRY.shape, 254)
        expected[row, 2:5] = 0
        np.testing.assert_array_equal(costmap.costs, expected)
    costmap.update()
    assert (costmap.costs == 254).all()
    assert costmap.update(pose=None) is None
