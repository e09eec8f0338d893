"""Masks, speed limits, given costs and columns of voxels, against values written down from Nav2's sources."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mapper.core.errors import ConfigError, ReadError
from mapper.costmap import (
    LETHAL,
    NO_INFORMATION,
    CostmapConfig,
    DecayConfig,
    DecayLayer,
    Footprint,
    GivenLayer,
    KeepoutLayer,
    LayeredCostmap,
    Mask,
    Observation,
    SpeedFilter,
    VoxelConfig,
    VoxelLayer,
)
from mapper.costmap.build import DEFAULT, build_costmap, load_masks
from mapper.costmap.masks import mask_costs
from mapper.costmap.nav2.filters import NamedFilter
from mapper.costmap.nav2.reading import parse_nav2_costmap
from mapper.costmap.nav2.writing import nav2_yaml
from mapper.grid import GridGeometry
from mapper.io.maps import load_map

GEOMETRY = GridGeometry(0.1, 40, 50)
GENERAL = CostmapConfig(track_unknown_space=True)
FILE = b"""
global_costmap:
  global_costmap:
    ros__parameters:
      robot_radius: 0.2
      plugins: [static_layer, zones, dynamic, inflation_layer]
      filters: [keepout_filter, speed_filter, lights]
      static_layer: {plugin: "nav2_costmap_2d::StaticLayer"}
      zones: {plugin: "nav2_costmap_2d::KeepoutFilter", filter_info_topic: "zones_info"}
      dynamic: {plugin: "gridbloom::DecayLayer", lifetime: 3.0, observation_sources: scan}
      inflation_layer: {plugin: "nav2_costmap_2d::InflationLayer"}
      keepout_filter: {plugin: "nav2_costmap_2d::KeepoutFilter", filter_info_topic: "/keepout_info"}
      speed_filter: {plugin: "nav2_costmap_2d::SpeedFilter", filter_info_topic: "/speed_info", speed_limit_topic: "/s"}
      lights: {plugin: "nav2_costmap_2d::BinaryFilter", filter_info_topic: "/light_info"}
keepout_info_server:
  ros__parameters: {type: 0, filter_info_topic: "/keepout_info", mask_topic: "/keepout_mask"}
zones_info_server:
  ros__parameters: {type: 0, filter_info_topic: "/zones_info", mask_topic: "/keepout_mask"}
speed_info_server:
  ros__parameters: {type: 2, filter_info_topic: "/speed_info", mask_topic: "/speed_mask", base: 1.5, multiplier: -0.01}
keepout_mask_server:
  ros__parameters: {topic_name: "/keepout_mask", yaml_filename: "zones.yaml"}
speed_mask_server:
  ros__parameters: {topic_name: "/speed_mask", yaml_filename: "zones.yaml"}
"""


def write_zones(folder: Path) -> None:
    """A mask of 5 × 4 cells of 1 m, the raw values row by row from above: 0, 1, 50, 100, unknown; the rest 0."""
    picture = np.zeros((4, 5), dtype=np.uint8)
    picture[0] = [0, 1, 50, 100, 255]
    Image.fromarray(picture).save(folder / "zones.pgm")
    (folder / "zones.yaml").write_text(
        "image: zones.pgm\nmode: raw\nresolution: 1.0\norigin: [0, 0, 0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.25\n"
    )


def test_filters_of_a_file_lie_where_nav2_has_them(tmp_path: Path) -> None:
    """Of the plugins' list under the inflation, of the filters' list above it; another resolution than the map's."""
    write_zones(tmp_path)
    found = parse_nav2_costmap(FILE)
    assert [(one.name, one.kind, one.below) for one in found.filters] == [
        ("keepout_filter", "keepout", None), ("speed_filter", "speed", None), ("lights", "binary", None),
        ("zones", "keepout", 1),
    ]  # fmt: skip
    built = build_costmap(GEOMETRY, np.zeros(GEOMETRY.shape, np.int8), found, masks=load_masks(found, tmp_path))
    costmap = built.costmap
    costmap.update()
    assert [layer.name for layer in costmap.below] == ["static_layer", "zones", "dynamic_layer", "painted_keepout"]
    assert [layer.name for layer in costmap.above] == ["keepout_filter"]
    assert built.unmasked == ("lights",)
    assert costmap.costs[35, [5, 15, 25, 35]].tolist() == [0, 3, 127, LETHAL], "value · 254 / 100, rounded"
    assert costmap.costs[28, 35] == 253, "the zone under the inflation is inflated"
    assert built.speed[0].at(1.5, 3.5).limit == pytest.approx(1.49)
    again = parse_nav2_costmap(nav2_yaml(found, 0.05).encode())
    assert set(again.filters) == set(found.filters)
    assert again.layers == found.layers


def test_a_filter_in_a_container_lies_in_it(tmp_path: Path) -> None:
    """A keepout zone below the container's own inflation is inflated by that."""
    write_zones(tmp_path)
    text = """
global_costmap:
  ros__parameters:
    plugins: [c]
    robot_radius: 0.3
    c:
      plugin: nav2_costmap_2d::PluginContainerLayer
      plugins: [zones, inflation]
      zones: {plugin: "nav2_costmap_2d::KeepoutFilter", filter_info_topic: /info}
      inflation: {plugin: "nav2_costmap_2d::InflationLayer"}
i: {ros__parameters: {type: 0, filter_info_topic: /info, mask_topic: /mask}}
m: {ros__parameters: {topic_name: /mask, yaml_filename: zones.yaml}}
"""
    for found in (first := parse_nav2_costmap(text.encode()), parse_nav2_costmap(nav2_yaml(first, 0.1).encode())):
        masks = load_masks(found, tmp_path)
        built = build_costmap(GEOMETRY, np.zeros(GEOMETRY.shape, np.int8), found, masks=masks)
        built.costmap.update()
        assert (built.costmap.costs[35, 35], built.costmap.costs[28, 35], built.unmasked) == (LETHAL, 253, ())


@pytest.mark.parametrize(
    "named", ["/home/anna/zones.yaml", "C:\\maps\\zones.yaml", "$(find-pkg-share my_maps)/maps/zones.yaml"]
)
def test_a_mask_that_is_named_elsewhere_is_the_one_beside_the_parameters(tmp_path: Path, named: str) -> None:
    write_zones(tmp_path)
    mask = load_masks(replace(DEFAULT, filters=(NamedFilter("k", "keepout", named),)), tmp_path)["k"]
    assert mask.notes[0].endswith("'zones.yaml' beside the parameter file is read in its place.")
    with pytest.raises(ReadError, match=r"The mask '.*other\.yaml' of k: There is no file 'other\.yaml'\."):
        load_masks(replace(DEFAULT, filters=(NamedFilter("k", "keepout", "/a/other.yaml"),)), tmp_path)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (b'{plugin: "nav2_costmap_2d::SpeedFilter"', r"speed_filter: The filter has no 'plugin' that is one of"),
        (b"type: 2", r"speed_info_server\.type must be 0, 1, 2 or 3"),
        (b"base: 1.5", r"speed_info_server\.base must be a number"),
    ],
)
def test_a_filter_with_an_error_is_refused_with_the_place(change: bytes, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        parse_nav2_costmap(FILE.replace(change, change.replace(b"plugin", b"kind").split(b":")[0] + b": fast"))


def test_costs_of_a_mask() -> None:
    """std::round(value · 254 / 100), and 255 for unknown."""
    assert mask_costs(np.array([-1, 0, 1, 25, 50, 75, 99, 100], np.int8)).tolist() == [
        255, 0, 3, 64, 127, 191, 251, 254,
    ]  # fmt: skip


def test_speed_limits() -> None:
    """By hand, from speed_filter.cpp: 0 is no limit, unknown and outside keep the last, impossible ones are none."""
    values = np.array([[0, 40, 100, -1]], dtype=np.int8)
    limits = SpeedFilter(Mask(GridGeometry(1.0, 1, 4), values), 1, base=10.0, multiplier=1.0)
    assert limits.at(0.5, 0.5).limit is None
    assert limits.at(1.5, 0.5).limit == 50.0
    assert limits.at(1.5, 0.5).of(0.8) == pytest.approx(0.4)
    for x in (3.5, 9.0):
        kept = limits.at(x, 0.5)
        assert (kept.limit, "the last limit holds" in kept.note) == (50.0, True)
    assert limits.at(2.5, 0.5) == limits.at(2.5, 0.5)
    assert "110 % is impossible" in limits.at(2.5, 0.5).note
    absolute = SpeedFilter(Mask(GridGeometry(1.0, 1, 4), values), 2, multiplier=0.02)
    assert absolute.at(2.5, 0.5).of(1.0) == 1.0
    assert absolute.at(1.5, 0.5).of(1.0) == pytest.approx(0.8)
    with pytest.raises(ConfigError, match="must be 1 or 2, not 0"):
        SpeedFilter(Mask(GridGeometry(1.0, 1, 4), values), 0)


@pytest.mark.parametrize("name", ["speed_mask.yaml", "depot_speed.yaml"])
def test_the_limits_of_a_real_mask(data_file: Callable[[str], Path], name: str) -> None:
    """Each cell's limit is that of the picture's grey, as Pillow reads it: value = 100 · (1 − grey / 255), percent."""
    loaded = load_map(data_file(f"maps/{name}"))
    with Image.open(data_file(f"maps/{name}").with_suffix(".pgm")) as image:
        grey = np.flipud(np.asarray(image.convert("L"))).astype(float)
    geometry = loaded.grid.geometry
    limits = SpeedFilter(Mask(geometry, loaded.values), 1)
    found = set()
    for row, col in np.random.default_rng(0).integers(0, geometry.shape, (300, 2)):
        expected = 100.0 * (1.0 - grey[row, col] / 255.0)
        limit = limits.at(*geometry.cell_to_world((row, col))).limit or 0.0
        assert limit == pytest.approx(expected, abs=1.0)
        found.add(limit)
    assert len(found) > 1


def test_given_costs() -> None:
    layer = GivenLayer(GEOMETRY, "terrain_layer", lambda row, col: f"Slope of ({row}, {col}).")
    costmap = LayeredCostmap(GEOMETRY, GENERAL, Footprint.circle(0.2), [layer])
    costmap.update()
    layer.set(np.full((2, 3), 100, np.uint8), 5, 6)
    box = costmap.update()
    assert box is not None
    assert (box.row0, box.row1, box.col0, box.col1) == (5, 7, 6, 9)
    assert costmap.costs[5:7, 6:9].tolist() == [[100] * 3] * 2
    assert costmap.costs[7, 6] == NO_INFORMATION
    assert costmap.why(5, 6)[0].sentence == "Slope of (5, 6)."
    with pytest.raises(ConfigError, match="are not within"):
        layer.set(np.zeros((2, 3), np.uint8), 39, 0)
    with pytest.raises(ConfigError, match="uint8"):
        layer.set(np.zeros((2, 3)))  # type: ignore[arg-type]


def test_columns_of_voxels() -> None:
    """A table of which one half is seen over, and a beam under it that does not free the column."""
    layer = VoxelLayer(GEOMETRY, VoxelConfig(z_voxels=10, z_resolution=0.1, obstacle_max_range=4.0), GENERAL)
    costmap = LayeredCostmap(GEOMETRY, GENERAL, Footprint.circle(0.2), [layer])
    low = np.array([0.55, 2.05, 0.25])
    layer.observe(Observation(low, np.array([[2.05, 2.05, 0.75], [2.05, 2.05, 0.05]])))
    costmap.update()
    assert costmap.costs[20, 20] == LETHAL
    assert layer.marked(20, 20) == pytest.approx([0.0, 0.7])
    layer.observe(Observation(low, np.array([[4.05, 2.05, 0.25]])))
    costmap.update()
    assert costmap.costs[20, 20] == LETHAL, "the beam passes between two marked voxels"
    assert "2 of 10 voxels are marked, from 0.00, 0.70 m up" in costmap.why(20, 20)[0].sentence
    for height in (0.05, 0.75):
        layer.observe(Observation(np.array([0.55, 2.05, height]), np.array([[4.05, 2.05, height]])))
    costmap.update()
    assert costmap.costs[20, 20] == 0, "no voxel is marked any more, and 7 unknown ones are fewer than 15"
    assert "0 of 10 voxels are marked and 7 unknown" in costmap.why(20, 20)[0].sentence


def test_a_mark_lives_as_long_as_its_own_stamp_says() -> None:
    """Stamps in any order, cells seen again, and time that goes backwards, against the whole grid's ages."""
    rng = np.random.default_rng(3)
    layer = DecayLayer(GEOMETRY, DecayConfig(lifetime=2.0, clearing=False), GENERAL)
    seen: dict[tuple[int, int], float] = {}
    for now in [*np.arange(0.0, 6.0, 0.3), 2.0, *np.arange(2.0, 8.0, 0.5)]:
        at = rng.uniform(1.0, 3.0, 2)
        stamp = now - rng.uniform(0.0, 1.0)
        layer.observe(Observation(np.array([2.0, 2.0, 0.2]), np.array([[*at, 0.2]]), stamp))
        row, col = GEOMETRY.world_to_cell(at)
        seen[int(row), int(col)] = stamp
        layer.changed(now, None)
        alive = {cell for cell, when in seen.items() if when >= now - 2.0}
        assert set(map(tuple, np.argwhere(layer.costs == LETHAL).tolist())) == alive


def test_a_painted_zone_and_a_mask_of_another_shape() -> None:
    layer = KeepoutLayer(GEOMETRY)
    layer.paint(np.array([[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]]), 1)
    assert layer.costs[15, 15] == 3
    with pytest.raises(ConfigError, match=r"has .* values for"):
        Mask(GEOMETRY, np.zeros((2, 2), np.int8))
