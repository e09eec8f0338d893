"""Parameter files as people of Nav2 have them, beside what Nav2 makes of each; one case of each kind.

A test names the source or the report that its situation is known from; those without one are of the same kinds.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from mapper.core.errors import ConfigError, LimitError, MapperError
from mapper.costmap import textbook
from mapper.costmap.build import build_costmap
from mapper.costmap.costs import FREE, LETHAL, NO_INFORMATION
from mapper.costmap.layers import Observation
from mapper.costmap.nav2.costmap import Nav2Costmap
from mapper.costmap.nav2.reading import parse_nav2_costmap
from mapper.costmap.nav2.writing import nav2_yaml
from mapper.costmap.parameters import COMBINATIONS, InflationConfig, ObstacleConfig, StaticConfig, VoxelConfig
from mapper.grid import GridGeometry
from mapper.io.ros_parameters import find_node, nodes_of, parse_ros_parameters, with_node
from mapper.localization import parse_amcl_yaml
from tests.mapper.planning.nav2_file import parse_nav2_path
from tests.server.cli.running import Run

STATIC = 'static_layer: {plugin: "nav2_costmap_2d::StaticLayer"}'
SEES_NOTHING = "global_costmap.{} has no observation_sources: as in Nav2 it sees nothing."
INFLATION = 'inflation_layer: {plugin: "nav2_costmap_2d::InflationLayer", inflation_radius: 0.7}'


def node(parameters: str, name: str = "global_costmap") -> Nav2Costmap:
    """Return the costmap of a file with these lines of parameters."""
    lines = "".join(f"      {line}\n" for line in parameters.strip().split("\n"))
    return parse_nav2_costmap(f"{name}:\n  {name}:\n    ros__parameters:\n{lines}".encode())


def lethal(found: Nav2Costmap) -> int:
    """Return how many cells of a map with 9 occupied and 20 unknown ones are lethal."""
    values = np.zeros((40, 50), dtype=np.int8)
    values[5:8, 5:8], values[20] = 100, np.where(np.arange(50) < 20, -1, 0)
    built = build_costmap(GridGeometry(0.1, 40, 50), values, found)
    built.costmap.update()
    assert (built.costmap.costs == NO_INFORMATION).any() == found.general.track_unknown_space
    return int((built.costmap.costs == LETHAL).sum())


NAMES = ("static_layer", "obstacle_layer", "inflation_layer")


@pytest.mark.parametrize(
    "parameters",
    [
        "resolution: 0.1",  # no list: default_plugins_
        'plugins: ["static_layer", "obstacle_layer", "inflation_layer"]',  # default_types_
        "plugins: [static_layer, obstacle_layer, inflation_layer]\nstatic_layer:\ninflation_layer: {enabled: true}",
    ],
)
def test_a_file_without_a_list_of_layers_or_their_types_has_nav2_s(parameters: str) -> None:
    """default_plugins_ and default_types_ of costmap_2d_ros.cpp."""
    found = node(parameters + "\ntrack_unknown_space: true")
    assert tuple(one.name for one in found.layers) == NAMES
    kinds = (StaticConfig, ObstacleConfig, InflationConfig)
    assert all(isinstance(one.config, kind) for one, kind in zip(found.layers, kinds, strict=True))
    assert lethal(found) == 9


def test_a_layer_without_a_type_in_another_list_is_refused_as_in_nav2() -> None:
    with pytest.raises(MapperError, match="only where the list 'plugins' is static_layer, obstacle_layer, inflation"):
        node("plugins: [static_layer, inflation_layer]")


DUMPS = {
    "fully qualified names": "/global_costmap/global_costmap:\n  ros__parameters:\n    {}",
    "a namespace": "/robot7/global_costmap/global_costmap:\n  ros__parameters:\n    {}",
    "namespaces as keys": "robot7:\n  global_costmap:\n    global_costmap:\n      ros__parameters:\n        {}",
    "of every node": "/**:\n  ros__parameters:\n    {}",
    "of every node of the name": "/**/global_costmap:\n  ros__parameters:\n    {}",
    "one level": "global_costmap:\n  ros__parameters:\n    {}",
}
WAYS = {
    "levels": ("plugins: [a, b]", "a: {plugin: nav2_costmap_2d::StaticLayer}",
               "b: {plugin: nav2_costmap_2d::InflationLayer, inflation_radius: 0.9}"),
    "dots": ("plugins: [a, b]", "a.plugin: nav2_costmap_2d::StaticLayer", "b.inflation_radius: 0.9",
             "b.plugin: nav2_costmap_2d::InflationLayer"),
    "both": ("b: {inflation_radius: 0.9}", "plugins: [a, b]", "a: {plugin: nav2_costmap_2d::StaticLayer}",
             "b.plugin: nav2_costmap_2d::InflationLayer"),
    "names of values": ("plugins: [a, b]", "a: {plugin: nav2_costmap_2d::StaticLayer}",
                        "c: &c {plugin: nav2_costmap_2d::InflationLayer, inflation_radius: 0.1}",
                        "b: {<<: *c, inflation_radius: 0.9}"),
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("dump", DUMPS)
def test_names_of_nodes_and_parameters_may_be_written_in_each_way_of_ros_2(dump: str, way: str) -> None:
    """rcl's parser of parameter files, and what ``ros2 param dump`` writes."""
    form = DUMPS[dump]
    indent = form.rpartition("\n")[2].removesuffix("{}")
    text = form.format(f"\n{indent}".join((*WAYS[way], "use_sim_time: true")))
    found = parse_nav2_costmap(f"amcl: {{ros__parameters: {{alpha1: 0.2}}}}\n{text}\n".encode())
    assert [(one.name, type(one.config)) for one in found.layers] == [("a", StaticConfig), ("b", InflationConfig)]
    assert found.layers[1].config == InflationConfig(inflation_radius=0.9)
    assert found.notes == ()


def test_what_is_said_of_every_node_holds_unless_the_node_says_otherwise() -> None:
    found = parse_nav2_costmap(
        b"/**: {ros__parameters: {robot_radius: 0.3, track_unknown_space: true, scan_topic: /scan}}\n"
        b"global_costmap: {global_costmap: {ros__parameters: {robot_radius: 0.4}}}\n"
    )
    assert (found.general.robot_radius, found.general.track_unknown_space) == (0.4, True)
    assert (found.others, found.notes) == ({}, (SEES_NOTHING.format("obstacle_layer"),))


def test_amcl_and_the_planner_of_a_dump() -> None:
    text = "/r/amcl:\n  ros__parameters:\n    laser.x: 1\n    alpha1: 0.3\n    initial_pose.x: 1.0\n"
    read = parse_amcl_yaml(text.encode())
    assert read.config.alpha1 == 0.3
    assert read.others == {"initial_pose": {"x": 1.0}}
    assert "no parameter 'laser'" in read.notes[0]
    planner = b"/planner_server: {ros__parameters: {planner_plugins: [G], G.plugin: N::NavfnPlanner, G.tolerance: 0.7}}"
    assert parse_nav2_path(planner).planner.tolerance == 0.7


NOT_BUILT = (
    "nav2_costmap_2d::RangeSensorLayer", "spatio_temporal_voxel_layer/SpatioTemporalVoxelLayer",
    "my_robot::ShoutingLayer",
)  # fmt: skip


@pytest.mark.parametrize("plugin", NOT_BUILT)
def test_a_layer_that_is_not_built_is_left_out_with_a_note_and_written_again(plugin: str) -> None:
    found = node(
        f"plugins: [static_layer, odd, inflation_layer]\n{STATIC}\n{INFLATION}\n"
        f'odd: {{plugin: "{plugin}", minimal_group_size: 2, topics: [/a, /b]}}'
    )
    assert [one.name for one in found.layers] == ["static_layer", "inflation_layer"]
    (note,) = found.notes
    assert note.startswith(f"global_costmap.odd: The layer '{plugin}' is not built here")
    assert lethal(found) == 9
    again = parse_nav2_costmap(nav2_yaml(found, 0.1).encode())
    assert again == found
    written = yaml.safe_load(nav2_yaml(found, 0.1))["global_costmap"]["global_costmap"]["ros__parameters"]
    assert written["plugins"] == ["static_layer", "odd", "inflation_layer"]


CONTAINER = """
track_unknown_space: true
robot_radius: 0.2
plugins: [static_layer, c, top]
static_layer: {plugin: "nav2_costmap_2d::StaticLayer", enabled: OUTER}
c:
  plugin: "nav2_costmap_2d::PluginContainerLayer"
  combination_method: METHOD
  enabled: ENABLED
  plugins: [static_layer, small, odd]
  static_layer: {plugin: "nav2_costmap_2d::StaticLayer"}
  small: {plugin: "nav2_costmap_2d::InflationLayer", inflation_radius: 0.3, cost_scaling_factor: 2.0}
  odd: {plugin: "nav2_costmap_2d::RangeSensorLayer"}
top: {plugin: "nav2_costmap_2d::InflationLayer", inflation_radius: 0.5, inflate_unknown: true}
"""


def container(method: int, *, enabled: bool = True, outer: bool = True) -> Nav2Costmap:
    words = {"METHOD": str(method), "ENABLED": str(enabled).lower(), "OUTER": str(outer).lower()}
    return node(re.sub("|".join(words), lambda found: words[found[0]], CONTAINER))


@pytest.mark.parametrize("method", [0, 1, 2])
@pytest.mark.parametrize("enabled", [True, False])
@pytest.mark.parametrize("outer", [True, False])
def test_a_container_lays_its_layers_together_over_those_before_it(method: int, enabled: bool, outer: bool) -> None:
    """PluginContainerLayer::updateCosts, since Kilted; its costs begin as NO_INFORMATION, its inflation is its own."""
    found = container(method, enabled=enabled, outer=outer)
    values = np.zeros((24, 30), dtype=np.int8)
    values[5:7, 5:8], values[18, 20], values[12:, :10] = 100, 100, -1
    built = build_costmap(GridGeometry(0.1, 24, 30), values, found)
    built.costmap.update()
    static = np.where(values < 0, NO_INFORMATION, np.where(values > 0, LETHAL, FREE)).astype(np.uint8)
    radius, nothing = found.outline.inscribed_radius, np.full(values.shape, NO_INFORMATION, dtype=np.uint8)
    expected = textbook.combine(nothing, static, "true_overwrite") if outer else nothing
    if enabled:
        together = textbook.inflate(static, 0.1, 3, radius, 2.0, inflate_unknown=False, inflate_around_unknown=False)
        expected = textbook.combine(expected, together, COMBINATIONS[method])
    expected = textbook.inflate(expected, 0.1, 5, radius, 10.0, inflate_unknown=True, inflate_around_unknown=False)
    assert built.costmap.costs.tolist() == expected.tolist()


def test_a_container_is_written_as_it_was_read() -> None:
    found = container(2)
    assert [one.name for one in found.all_layers()] == ["static_layer", "c", "c.static_layer", "c.small", "top"]
    assert "global_costmap.c.odd: The layer 'nav2_costmap_2d::RangeSensorLayer' is not built here" in found.notes[0]
    assert replace(parse_nav2_costmap(nav2_yaml(found, 0.1).encode()), others={}) == replace(found, others={})
    assert "c.small: The inflation radius of 0.3 m" not in " ".join(found.notes)
    built = build_costmap(GridGeometry(0.1, 8, 8), np.full((8, 8), 100, np.int8), found)
    built.costmap.update()
    assert built.costmap.why(4, 4)[1].sentence.startswith("Its layers make lethal together. static_layer: The map’s")


CONTAINERS = {
    "a layer without a type": (('{plugin: "nav2_costmap_2d::InflationLayer", inflation_radius: 0.3', "{e: 3"),
                               r"global_costmap\.c\.small: The layer has no 'plugin'"),
    "a method that there is not": (("METHOD", "3"), r"global_costmap\.c\.combination_method must be 0, 1 or 2"),
    "no value for enabled": (("ENABLED", "7"), r"global_costmap\.c\.enabled: Enabled \(enabled\) must be true"),
}  # fmt: skip


@pytest.mark.parametrize("case", CONTAINERS)
def test_what_is_wrong_in_a_container_is_named_by_its_path(case: str) -> None:
    (old, new), said = CONTAINERS[case]
    text = CONTAINER.replace(old, new)
    with pytest.raises(MapperError, match=said):
        node(text.replace("METHOD", "1").replace("ENABLED", "true").replace("OUTER", "true"))


@pytest.mark.parametrize("word", ["7e-1", "7E-01", "0.07e1", ".7", "+7.e-1"])
def test_numbers_are_those_of_yaml_1_2_and_of_rcl(word: str) -> None:
    """PyYAML follows YAML 1.1, in which 7e-1 is a text; rcl reads it with strtod."""
    assert node(f"plugins: []\nrobot_radius: {word}").general.robot_radius == 0.7


@pytest.mark.parametrize(
    "text", ["[(0.3, 0.2), (0.3, -0.2), (-0.3, 0)]", "[[0.3, 0.2], [0.3, -0.2]]", "[[0.3, 0.2], [0.3, -0.2",
             "[1, 2, 3]", "[[0.3, 0.2], [0.3, -0.2], [-0.3, 'a']]", "round"],
)  # fmt: skip
def test_a_footprint_that_is_none_leaves_the_radius_as_in_nav2(text: str) -> None:
    """Costmap2DROS::getParameters: "The footprint parameter is invalid … using radius instead"."""
    found = node(f'robot_radius: 0.4\nfootprint: "{text}"\n')
    assert (found.footprint, found.general.robot_radius) == (None, 0.4)
    assert found.notes[0].startswith(f"global_costmap.footprint, {text!r:.80}, is no list of three points")


def test_the_value_for_unknown_of_ros_1_is_the_greatest_byte() -> None:
    """costmap_2d has -1, and Nav2 an unsigned byte."""
    found = node("plugins: [static_layer]\nunknown_cost_value: -1\ntrack_unknown_space: true\n" + STATIC)
    assert (found, lethal(found)) == (node("plugins: [static_layer]\ntrack_unknown_space: true\n" + STATIC), 9)


def test_a_robot_without_an_extent_is_named() -> None:
    with pytest.raises(
        MapperError, match=r"global_costmap\.robot_radius must be more than 0 m, or there must be a foot"
    ):
        node("robot_radius: 0.0")
    assert node('robot_radius: 0.0\nfootprint: "[[1, 1], [-1, 1], [0, -1]]"').footprint is not None


def test_the_inflation_of_earlier_releases_is_built_by_its_new_name() -> None:
    """LegacyInflationLayer, after Kilted: what InflationLayer was, with the same parameters."""
    old = node(f"plugins: [static_layer, inflation_layer]\n{STATIC}\n{INFLATION}")
    assert node(f"plugins: [static_layer, inflation_layer]\n{STATIC}\n{INFLATION.replace('::', '::Legacy')}") == old


def test_a_source_whose_greatest_height_is_not_stated_has_a_note() -> None:
    """obstacle_layer.cpp declares 0.0 for a source: readings of a lidar above the ground mark nothing."""
    text = 'plugins: [o]\no: {plugin: "nav2_costmap_2d::ObstacleLayer", observation_sources: scan, scan: {MORE}}'
    said = "global_costmap.o.scan states no max_obstacle_height, which is 0 m then in Nav2"
    assert node(text.replace("MORE", "topic: /scan")).notes[0].startswith(said)
    for more in ("max_obstacle_height: 2.0", "marking: false"):
        assert not any(said in note for note in node(text.replace("MORE", more)).notes)


def test_names_that_a_filter_does_not_declare_have_no_effect() -> None:
    text = 'plugins: []\nfilters: [k]\nk: {plugin: "nav2_costmap_2d::KeepoutFilter", MORE: true}'
    assert "declares no parameter 'enable' (did you mean 'enabled'?)" in node(text.replace("MORE", "enable")).notes[0]
    assert node(text.replace("MORE", "override_lethal_cost")).notes == node(text.replace(", MORE: true", "")).notes


TYPES = {
    "robot_radius: 1": "global_costmap.robot_radius is 1, where Nav2 declares a double, and does not start: write 1.0.",
    "width: 3.0": "global_costmap.width is 3.0, where Nav2 declares an integer, and does not start: write 3.",
    "height: 2.5": "global_costmap.height is 2.5, where Nav2 declares an integer, and does not start: it must be",
    "footprint: [[1, 0], [0, 1], [0, -1]]": "global_costmap.footprint is a list, where Nav2 declares a text, and does",
    "lethal_cost_threshold: 90.0": "global_costmap.lethal_cost_threshold is 90.0, where Nav2 declares an integer, and",
}


@pytest.mark.parametrize("line", TYPES)
def test_a_number_of_the_other_type_has_a_note(line: str) -> None:
    """navigation2#1874, #1976, #3561: rclcpp refuses an integer for a double, and Nav2 does not start."""
    found = node(f'plugins: [s]\ns: {{plugin: "nav2_costmap_2d::StaticLayer"}}\n{line}')
    assert found.notes[0].startswith(TYPES[line])
    assert parse_nav2_costmap(nav2_yaml(node("plugins: [static_layer]\n" + STATIC), 0.1).encode()).notes == ()
    assert parse_amcl_yaml(b"amcl: {ros__parameters: {laser_max_range: 100, max_beams: 60}}").notes == (
        "amcl.laser_max_range is 100, where Nav2 declares a double, and does not start: write 100.0.",
    )


def test_thresholds_are_written_as_the_integers_that_nav2_declares() -> None:
    """costmap_2d_ros.cpp declares lethal_cost_threshold, inscribed_obstacle_cost_value and unknown_cost_value so."""
    written = nav2_yaml(node("plugins: [static_layer]\n" + STATIC), 0.1)
    values = yaml.safe_load(written)["global_costmap"]["global_costmap"]["ros__parameters"]
    names = ("lethal_cost_threshold", "inscribed_obstacle_cost_value", "unknown_cost_value")
    assert [(values[name], type(values[name])) for name in names] == [(100, int), (99, int), (255, int)]


TWICE = "The key {!r} occurs twice, in lines {} and {}: the latter alone counts, as in Nav2’s launch files."


def test_a_key_that_stands_twice_has_a_note() -> None:
    """PyYAML takes the last one without a word: of a block that is repeated the first one's layers were lost."""
    first = "global_costmap:\n  global_costmap: {ros__parameters: {plugins: [static_layer]}}\n"
    second = "global_costmap:\n  global_costmap: {ros__parameters: {robot_radius: 0.4, robot_radius: 0.5}}\n"
    found = parse_nav2_costmap((first + second).encode())
    assert found.general.robot_radius == 0.5
    assert found.notes == (TWICE.format("robot_radius", 4, 4), TWICE.format("global_costmap", 1, 3),
                           SEES_NOTHING.format("obstacle_layer"))  # fmt: skip
    amcl = parse_amcl_yaml(b"amcl:\n  ros__parameters:\n    alpha1: 0.1\n    alpha1: 0.3\n")
    assert (amcl.config.alpha1, amcl.notes) == (0.3, (TWICE.format("alpha1", 3, 4),))
    merged = b"x: &x {a: 1}\namcl: {ros__parameters: {alpha1: 0.3, b: {<<: *x, a: 2}, c: {<<: *x, <<: *x}}}\n"
    assert not any("twice" in note for note in parse_amcl_yaml(merged).notes)


def test_of_a_node_that_stands_in_two_ways_all_parameters_count() -> None:
    found = parse_nav2_costmap(
        b"global_costmap: {global_costmap: {ros__parameters: {plugins: [s], s: {plugin: 'N::StaticLayer'}}}}\n"
        b"/global_costmap/global_costmap: {ros__parameters: {robot_radius: 0.4, s.footprint_clearing_enabled: true}}\n"
    )
    assert (found.general.robot_radius, found.layers[0].config) == (0.4, StaticConfig(footprint_clearing_enabled=True))


def test_what_looks_right_and_is_not_what_nav2_reads_has_a_note_or_says_why() -> None:
    """static_layer.cpp asks the costmap for its thresholds; observation sources are split at spaces alone."""
    found = node(
        'plugins: [s]\ns: {plugin: "my_pkg::StaticLayer", lethal_cost_threshold: 50}\nlethal_cost_threshold: 80'
    )
    assert found.layers[0].config == StaticConfig(lethal_cost_threshold=80)
    assert [note.partition(": ")[2][:50] for note in found.notes] == [
        "'my_pkg::StaticLayer' is another package’s; it is ", "Nav2 (Foxy to Kilted) declares no parameter 'letha",
    ]  # fmt: skip
    layer = 'plugins: [o]\no: {plugin: "nav2_costmap_2d::ObstacleLayer", '
    assert "'a, b', has commas" in node(layer + 'observation_sources: "a, b"}').notes[0]
    with pytest.raises(MapperError, match=r"combination_method must be 0, 1 or 2, not 1\.0"):
        node(layer + "combination_method: 1.0}")
    with pytest.raises(MapperError, match="with ros__parameters: 'ros_parameters' is there instead"):
        parse_nav2_costmap(b"global_costmap: {global_costmap: {ros_parameters: {robot_radius: 0.3}}}")
    assert node("plugins: []\nfootprint: []").footprint is None


def test_small_groups_are_removed_as_nav2_does() -> None:
    """nav2_costmap_2d's DenoiseLayer, with its defaults and with its parameters; the inflation sees what remains."""
    values = np.zeros((9, 9), dtype=np.int8)
    values[1, 1] = values[4, 4] = values[5, 5] = 100  # one alone, and two that have a corner in common
    values[7, 2:6] = 100
    first = f"plugins: [static_layer, d, inflation_layer]\n{STATIC}\n{INFLATION}\n"
    geometry = GridGeometry(1.0, 9, 9)
    left = {"": 6, ", group_connectivity_type: 4": 4, ", minimal_group_size: 5": 0, ", enabled: false": 7}
    for more, count in left.items():
        found = node(f'{first}d: {{plugin: "nav2_costmap_2d::DenoiseLayer"{more}}}')
        assert found.notes == ()
        built = build_costmap(geometry, values, found)
        built.costmap.update()
        assert np.count_nonzero(built.costmap.costs == LETHAL) == count, more
        assert parse_nav2_costmap(nav2_yaml(found, 1.0).encode()) == found
    found = node(f'{first}d: {{plugin: "nav2_costmap_2d::DenoiseLayer"}}')
    built = build_costmap(geometry, values, found)
    built.costmap.update()
    reasons = {one.layer: one.sentence for one in built.costmap.why(1, 1)}
    assert "fewer than 2 cells, which is removed as noise" in reasons["d"]
    assert "No obstacle of a group" in {one.layer: one.sentence for one in built.costmap.why(4, 4)}["d"]


def test_of_two_inflation_layers_the_upper_one_is_built() -> None:
    found = node(
        f"plugins: [static_layer, low, inflation_layer]\n{STATIC}\n{INFLATION}\nlow: {{plugin: a::InflationLayer}}"
    )
    assert [one.name for one in found.layers] == ["static_layer", "inflation_layer"]
    assert "stands below 'inflation_layer'" in found.notes[0]


KNOWN = {
    "sources of the costmap": "observation_sources: scan\nscan: {topic: /scan, data_type: LaserScan}",
    "a layer that is not in use": "voxel_layer: {enabled: true, z_voxels: 16}",
    "a layer's parameters in Foxy": "static_layer.map_subscribe_transient_local: true",
    "Foxy's list of layers to clear": "clearable_layers: [obstacle_layer]\nmap_topic: /map",
    "rclcpp's": "use_sim_time: true\nqos_overrides: {/tf: {subscription: {depth: 1}}}",
    "an empty list of filters": 'filters: [""]',
    "Kilted's": "introspection_mode: disabled\nallow_parameter_qos_overrides: true\nbond_heartbeat_period: 0.1",
}


@pytest.mark.parametrize("case", KNOWN)
def test_what_nav2_declares_is_no_error_and_has_no_note(case: str) -> None:
    """The calls of declare_parameter in costmap_2d_ros.cpp and the layers of nav2_costmap_2d."""
    found = node(f"plugins: [static_layer, inflation_layer]\n{STATIC}\n{INFLATION}\n{KNOWN[case]}")
    assert (lethal(found), found.notes) == (9, ())


def test_an_old_name_is_read_and_named_with_the_new_one() -> None:
    """Foxy's obstacle_layer.cpp."""
    found = node(
        "plugins: [static_layer, o]\n" + STATIC + "\no: {plugin: nav2_costmap_2d::ObstacleLayer, "
        "observation_sources: scan, scan: {obstacle_range: 4.5, raytrace_range: 6.0, clearing: true, "
        "max_obstacle_height: 2.0}}"
    )
    assert isinstance(found.layers[1].config, ObstacleConfig)
    config = found.layers[1].config.source("scan")
    assert (config.obstacle_max_range, config.raytrace_max_range, config.clearing) == (4.5, 6.0, True)
    assert [note.partition(";")[0] for note in found.notes] == [
        "global_costmap.o.scan.obstacle_range is named obstacle_max_range since Galactic",
        "global_costmap.o.scan.raytrace_range is named raytrace_max_range since Galactic",
    ]
    old = node(
        "plugin_names: [s, i]\nplugin_types: ['nav2_costmap_2d::StaticLayer', 'nav2_costmap_2d::InflationLayer']"
    )
    assert [one.name for one in old.layers] == ["s", "i"]
    assert "since Foxy the list is 'plugins'" in old.notes[0]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("robot_radius_m: 0.2", "declares no parameter 'robot_radius_m' (did you mean 'robot_radius'?)"),
        ("inflation_layer.inflaton_radius: 0.2", "'inflaton_radius' (did you mean 'inflation_radius'?)"),
        (
            "static_layer.colour: red",
            "global_costmap.static_layer: Nav2 (Foxy to Kilted) declares no parameter 'colour'",
        ),
    ],
)
def test_a_name_that_nav2_does_not_declare_has_a_note(line: str, said: str) -> None:
    found = node(f"plugins: [static_layer, inflation_layer]\n{STATIC}\n{INFLATION}\n{line}")
    (note,) = found.notes
    assert said in note
    assert note.endswith("it has no effect there, nor here.")


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("robot_radius: wide", "global_costmap.robot_radius: "),
        ("inflation_layer.cost_scaling_factor: -1.0", "global_costmap.inflation_layer.cost_scaling_factor: "),
        ("static_layer: 7", "has a value, and parameters below it"),
        ("filters: '[keepout_filter]'", "filters must be a list of names, not .* in quotes for a text"),
        ("robot_radius: {{ radius }}", r"malformed in line \d+: it has a template’s"),
        ("\trobot_radius: 0.2", r"malformed in line \d+: it is indented with a tab"),
    ],
)
def test_a_value_that_is_wrong_is_an_error_with_its_path(line: str, said: str) -> None:
    with pytest.raises(MapperError, match=said):
        node(f"plugins: [static_layer, inflation_layer]\nstatic_layer.plugin: a::StaticLayer\n{INFLATION}\n{line}")


@pytest.mark.parametrize(("radius", "warns"), [(0.35, True), (0.37, False)])
def test_an_inflation_radius_below_the_inscribed_radius_has_nav2_s_warning(radius: float, warns: bool) -> None:
    """navigation2#4271, and its pull request 5148."""
    found = node(
        f'footprint: "[[0.45,0.35],[0.45,-0.35],[-0.45,-0.35],[-0.45,0.35]]"\n'
        f"plugins: [static_layer, i]\n{STATIC}\ni: {{plugin: n::InflationLayer, inflation_radius: {radius}}}"
    )
    warned = [note for note in found.notes if "smaller than the inscribed radius of the footprint, 0.360 m" in note]
    assert bool(warned) == warns


def test_a_local_costmap_without_the_map_says_so() -> None:
    found = node("plugins: [v]\nv: {plugin: nav2_costmap_2d::VoxelLayer}\nrolling_window: true", "local_costmap")
    assert lethal(found) == 0
    assert "local_costmap has no static layer in use: nothing of the map is in its costs" in found.notes[0]


def test_values_beyond_what_is_computed_with_are_taken_as_the_nearest() -> None:
    """Heights of 1000 m stand for no limit; z_voxels above 16 are 16 in Nav2's VoxelGrid too."""
    found = node(
        "plugins: [s, v]\ns: {plugin: nav2_costmap_2d::StaticLayer}\n"
        "v: {plugin: nav2_costmap_2d::VoxelLayer, z_voxels: 20, max_obstacle_height: 1000.0, "
        "min_obstacle_height: -1000.0}"
    )
    config = found.layers[1].config
    assert isinstance(config, VoxelConfig)
    assert (config.z_voxels, config.max_obstacle_height, config.min_obstacle_height) == (16, 50.0, -10.0)
    assert found.notes == (
        "global_costmap.v.z_voxels is 20, more than is computed with here: 16 is taken.",
        "global_costmap.v.max_obstacle_height is 1000, more than is computed with here: 50 m is taken.",
        "global_costmap.v.min_obstacle_height is -1000, less than is computed with here: -10 m is taken.",
        SEES_NOTHING.format("v"),
    )
    endless = node("plugins: [o]\no: {plugin: nav2_costmap_2d::ObstacleLayer, max_obstacle_height: .inf}")
    assert isinstance(endless.layers[0].config, ObstacleConfig)
    assert endless.layers[0].config.max_obstacle_height == 50.0
    assert endless.notes[0].startswith("global_costmap.o.max_obstacle_height is inf, more than is computed with here")
    read = parse_amcl_yaml(b"amcl: {ros__parameters: {lambda_short: 30.0}}")
    assert (read.config.lambda_short, len(read.notes)) == (10.0, 1)


def test_a_value_that_is_filled_in_at_the_launch_is_named_as_such() -> None:
    for value in ("$(var radius)", "<radius>"):
        with pytest.raises(MapperError, match=r"global_costmap\.robot_radius: .* filled in where Nav2 is launched"):
            parse_nav2_costmap(f"/**/global_costmap: {{ros__parameters: {{robot_radius: {value}}}}}".encode())
    found = parse_nav2_costmap(
        b"global_costmap: {ros__parameters: {robot_radius: 0.3, use_sim_time: $(var t), global_frame: <ns>/map}}"
    )
    assert (found.general.robot_radius, found.notes) == (0.3, (SEES_NOTHING.format("obstacle_layer"),))


def test_the_filters_of_nav2_s_own_file_are_on_as_by_its_launch_file() -> None:
    """nav2_params.yaml of Kilted has words in place of values; RewrittenYaml of its launch file fills them in."""
    block = '{plugin: "nav2_costmap_2d::KeepoutFilter", enabled: KEEPOUT_ZONE_ENABLED, override_lethal_cost: True}'
    found = node(f"plugins: [static_layer]\n{STATIC}\nfilters: [keepout_filter]\nkeepout_filter: {block}")
    assert found.filters[0].enabled
    (note,) = found.notes
    assert note.startswith(
        "global_costmap.keepout_filter.enabled is KEEPOUT_ZONE_ENABLED, which is filled in where Nav2"
    )
    with pytest.raises(MapperError, match="must be true or false, not 'maybe'"):
        node(f"plugins: []\nfilters: [f]\nf: {block.replace('KEEPOUT_ZONE_ENABLED', 'maybe')}")
    with pytest.raises(MapperError, match="filled in where Nav2 is launched"):
        node("robot_radius: ROBOT_RADIUS")


def test_costmaps_of_several_robots_are_named() -> None:
    of_one = "/{0}/global_costmap/global_costmap: {{ros__parameters: {{robot_radius: 0.{1}}}}}\n"
    found = parse_nav2_costmap((of_one.format("a", 2) + of_one.format("b", 4)).encode())
    assert found.general.robot_radius == 0.2
    assert found.notes[0] == (
        "The parameter file has 2 nodes global_costmap: a/global_costmap/global_costmap is taken, not "
        "b/global_costmap/global_costmap."
    )


OTHER_PLANNERS = {
    "nav2_smac_planner::SmacPlanner2D": "cost_travel_multiplier: 2.0",
    "nav2_smac_planner/SmacPlannerHybrid": "minimum_turning_radius: 0.4",
    "nav2_smac_planner::SmacPlannerLattice": "lattice_filepath: a.json",
    "nav2_theta_star_planner::ThetaStarPlanner": "how_many_corners: 8",
}


@pytest.mark.parametrize("plugin", OTHER_PLANNERS)
def test_a_planner_that_is_not_built_is_named_with_the_one_in_its_place(plugin: str) -> None:
    block = f'{{plugin: "{plugin}", {OTHER_PLANNERS[plugin]}, smoother: {{w_smooth: 0.3}}}}'
    text = f"planner_server: {{ros__parameters: {{planner_plugins: [G], costmap_update_timeout: 1.0, G: {block}}}}}"
    (note,) = parse_nav2_path(text.encode()).notes
    assert note == f"planner_server.G: {plugin!r} is not built here; the path is that of NavFn with Nav2’s defaults."
    both = text.replace("[G]", "[N, G]").replace("G: {", "N: {plugin: n::NavfnPlanner}, G: {")
    assert parse_nav2_path(both.encode()).notes == ()


def test_a_follower_that_is_not_built_is_named_with_the_one_in_its_place() -> None:
    for plugin in ("nav2_mppi_controller::MPPIController", "dwb_core::DWBLocalPlanner"):
        text = (
            f"controller_server: {{ros__parameters: {{FollowPath: {{plugin: {plugin}, critics: [A], A.scale: 2.0}}}}}}"
        )
        (note,) = parse_nav2_path(text.encode()).notes
        assert note.startswith(f"controller_server.FollowPath: {plugin!r} is not built here; the path is followed by")


@pytest.mark.parametrize("text", ["obstacle_range: 2.5\nfootprint: [[0, 0]]\n", "global_costmap: {robot_radius: 0.3}"])
def test_a_file_of_ros_1_is_named_as_such(text: str) -> None:
    with pytest.raises(MapperError, match="one of ROS 1’s move_base, whose nodes have their parameters directly"):
        parse_nav2_costmap(text.encode())


def test_a_file_of_other_nodes_is_refused_with_their_names() -> None:
    with pytest.raises(MapperError, match="it has amcl, r1/map_server"):
        parse_nav2_costmap(b"amcl: {ros__parameters: {a: 1}}\n/r1/map_server: {ros__parameters: {b: 1}}")


ROOM = "image: room.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"


@pytest.mark.parametrize("unknown", [(), ("--no-unknown",)])
def test_a_path_over_cells_that_count_as_free_says_so(tmp_path: Path, run: Run, unknown: tuple[str, ...]) -> None:
    """navigation#223, navigation#261: track_unknown_space is off."""
    picture = np.full((30, 60), 254, np.uint8)
    picture[:, 30:40] = 205
    (tmp_path / "room.pgm").write_bytes(b"P5\n60 30\n255\n" + picture.tobytes())
    (tmp_path / "room.yaml").write_text(ROOM)
    params = tmp_path / "nav2.yaml"
    params.write_text("global_costmap: {ros__parameters: {track_unknown_space: false, robot_radius: 0.1}}")
    done = run("path", tmp_path / "room.yaml", "--params", params, "--from", "1,1.5", "--to", "5,1.5", *unknown)
    assert done.status == 0
    assert "300 cells are unknown in the map and count as free: track_unknown_space is off" in done.out
    assert "10 of the points are in cells that the map does not know" in done.out


def test_a_footprint_beside_the_robots_centre_is_taken_with_a_note() -> None:
    """makeFootprintFromString of nav2_costmap_2d asks for three points, and no more."""
    found = node('footprint: "[[1, -1], [2, -1], [2, 1], [1, 1]]"\nfootprint_padding: 0.0\n')
    assert found.outline.inscribed_radius == pytest.approx(1.0)
    assert found.notes[0].startswith("global_costmap.footprint does not hold (0, 0), about which the robot turns.")


def test_an_inflation_radius_of_too_many_cells_is_refused_by_its_path() -> None:
    found = node("inflation_layer: {inflation_radius: 15.0}")
    with pytest.raises(
        LimitError, match=r"^global_costmap\.inflation_layer\.inflation_radius: An .* is 300 cells of 0\.05"
    ):
        build_costmap(GridGeometry(0.05, 8, 8), np.zeros((8, 8), np.int8), found)


SOURCES = """
plugins: [o]
o:
  plugin: nav2_costmap_2d::{}
  max_obstacle_height: 1.0
  observation_sources: near far clears
  near: {{obstacle_max_range: 1.0, max_obstacle_height: 2.0}}
  far: {{obstacle_min_range: 1.5, obstacle_max_range: 9.0, min_obstacle_height: 0.3, max_obstacle_height: 2.0}}
  clears: {{marking: false, clearing: true, raytrace_max_range: 9.0, max_obstacle_height: 0.5}}
"""


@pytest.mark.parametrize("kind", ["ObstacleLayer", "VoxelLayer"])
def test_each_source_of_observations_has_its_own_parameters(kind: str) -> None:
    """Of nav2_costmap_2d: obstacle_layer.cpp (onInitialize, updateBounds), observation_buffer.cpp (bufferCloud)."""
    found = node(SOURCES.format(kind))
    again = parse_nav2_costmap(nav2_yaml(found, 0.1).encode())
    assert again.layers == found.layers
    layer = build_costmap(GridGeometry(0.1, 20, 60), np.zeros((20, 60), np.int8), again).obstacles[0]
    sensor = np.array([0.55, 1.05, 0.4])

    def marked() -> list[int]:
        layer.changed(0.0, None)
        return [int(col) for col in np.flatnonzero((layer.costs == 254).any(axis=0))]

    def see(source: str, *points: tuple[float, float]) -> None:
        layer.observe(Observation(sensor, np.array([[x, 1.05, z] for x, z in points]), source=source))

    everywhere = [(1.25, 0.4), (3.05, 0.4), (3.55, 0.1), (4.05, 1.4)]
    see("near", *everywhere)
    assert marked() == [12], "the others are farther than 1 m"
    see("far", *everywhere)
    assert marked() == [12, 30], "too near, then too low for the source, and too high for the layer"
    see("clears", (5.05, 0.7))
    assert marked() == [12, 30], "what is higher than its source's limit does not clear either"
    see("clears", (5.05, 0.4))
    assert marked() == []
    seen = np.array([[1.25, 1.05, 0.4]])
    layer.observe(Observation(sensor, seen, source="near"), Observation(sensor, seen, source="clears"))
    assert marked() == [12], "all sources clear first, then all mark"
    with pytest.raises(ConfigError, match="no source of observations 'rear'"):
        see("rear", (1.0, 0.4))


def test_a_value_of_a_source_is_refused_by_its_path() -> None:
    with pytest.raises(ConfigError, match=r"^global_costmap\.o\.far\.obstacle_min_range: "):
        node(SOURCES.format("ObstacleLayer").replace("obstacle_min_range: 1.5", "obstacle_min_range: -1.5"))


@pytest.mark.parametrize("kind", ["ObstacleLayer", "VoxelLayer"])
def test_a_layer_without_sources_sees_nothing_as_in_nav2(kind: str) -> None:
    """ObstacleLayer::onInitialize subscribes to the names in observation_sources, which is empty by default."""
    found = node(f"plugins: [o]\no: {{plugin: nav2_costmap_2d::{kind}, scan: {{topic: /scan}}}}")
    assert SEES_NOTHING.format("o") in found.notes
    config = found.layers[0].config
    assert isinstance(config, ObstacleConfig)
    assert config.sources_of_scans() == ()
    again = yaml.safe_load(nav2_yaml(found, 0.05))["global_costmap"]["global_costmap"]["ros__parameters"]["o"]
    assert not again["observation_sources"]
    off = node(f"plugins: [o]\no: {{plugin: nav2_costmap_2d::{kind}, enabled: false}}")
    assert SEES_NOTHING.format("o") not in off.notes


def test_a_footprint_that_crosses_itself_has_the_radii_of_nav2_and_a_note() -> None:
    """calculateMinAndMaxDistances of nav2_costmap_2d takes the edges in the order of the points, whatever they do."""
    found = node('footprint: "[[0.3, 0.2], [-0.3, -0.2], [0.3, -0.2], [-0.3, 0.2]]"\nfootprint_padding: 0.0')
    assert found.outline.inscribed_radius == pytest.approx(0.0, abs=1e-9)
    assert found.outline.circumscribed_radius == pytest.approx(math.hypot(0.3, 0.2))
    assert any(
        "the edges from point 0 and from point 2 meet. As in Nav2 it is taken as it is" in n for n in found.notes
    )
    beside = node('footprint: "[[1, 0], [3, 1], [3, 0], [1, 1]]"\nfootprint_padding: 0.0')
    assert beside.outline.inscribed_radius == pytest.approx(1.0)


def test_what_only_sources_have_does_nothing_in_their_layer() -> None:
    found = node(SOURCES.format("ObstacleLayer").replace("max_obstacle_height: 1.0", "obstacle_max_range: 1.0", 1))
    assert found.others["o", "obstacle_max_range"] == 1.0
    assert any("declares no parameter 'obstacle_max_range'" in note for note in found.notes)


def test_the_node_that_is_read_is_the_one_that_is_replaced() -> None:
    """In a file with two robots, and of a node that occurs twice; a file without the node gets it."""
    two = b"""
/r1/global_costmap/global_costmap: {ros__parameters: {robot_radius: 0.1}}
r2: {global_costmap: {global_costmap: {ros__parameters: {robot_radius: 0.2}}}}
r1: {global_costmap: {global_costmap: {ros__parameters: {width: 4}}}, amcl: {ros__parameters: {alpha1: 0.3}}}
"""
    root = parse_ros_parameters(two)
    made = with_node(root, "global_costmap", {"robot_radius": 0.7}, ("global_costmap", "global_costmap"))
    assert find_node(made, ("global_costmap",)) == ("global_costmap", {"robot_radius": 0.7})
    assert dict(nodes_of(made))["r2", "global_costmap", "global_costmap"] == {"robot_radius": 0.2}
    assert dict(nodes_of(made))["r1", "amcl"] == {"alpha1": 0.3}
    assert dict(nodes_of(root))["r1", "global_costmap", "global_costmap"] == {"robot_radius": 0.1, "width": 4}
    added = with_node(made, "planner_server", {"a": 1}, ("planner_server",))
    assert find_node(added, ("planner_server",)) == ("planner_server", {"a": 1})


def test_layers_after_the_inflation_have_a_note() -> None:
    """husarion/husarion_ugv_autonomy_ros#16, navigation2#4750: in a list of plugins the inflation is not the last.

    LayeredCostmap::updateMap: an inflation layer sees the costs of the layers before it alone.
    """
    stands = "global_costmap.inflation_layer stands before {} in the list: as in Nav2 it inflates only what"
    values = np.zeros((40, 50), dtype=np.int8)
    values[20, 25] = 100
    for order, named in (
        ("static_layer, inflation_layer", None),
        ("inflation_layer, static_layer", "static_layer"),
        ("static_layer, inflation_layer, seen", "seen"),
    ):
        seen = 'seen: {plugin: "nav2_costmap_2d::ObstacleLayer", observation_sources: scan, scan: {marking: false}}'
        found = node(f"plugins: [{order}]\n{STATIC}\n{INFLATION}\n{seen}\nrobot_radius: 0.2")
        built = build_costmap(GridGeometry(0.1, 40, 50), values, found)
        built.costmap.update()
        assert (built.costmap.costs[20, 24] > 0) == (named != "static_layer"), order
        noted = [note for note in found.notes if "stands before" in note]
        assert len(noted) == (named is not None), order
        assert named is None or noted[0].startswith(stands.format(named))
    off = f"plugins: [inflation_layer, static_layer]\n{STATIC}\n{INFLATION.replace('{', '{enabled: false, ')}"
    assert not any("stands before" in note for note in node(off).notes)


@pytest.mark.parametrize("key", ["plugins", "filters"])
def test_a_name_that_is_twice_in_a_list_is_named(key: str) -> None:
    with pytest.raises(ConfigError, match=rf"global_costmap\.{key} has the name 'static_layer' twice: leave one out"):
        node(f"{key}: [static_layer, static_layer]\n{STATIC}")


def filters(info: str) -> Nav2Costmap:
    """Return the costmap of a file with a keepout and a speed filter, and these nodes."""
    nodes = "".join(
        f"{name}: {{ros__parameters: {{{values}}}}}\n"
        for name, values in (line.split(" ", 1) for line in info.strip().split("\n"))
    )
    costmap = (
        "global_costmap: {global_costmap: {ros__parameters: {robot_radius: 0.2, plugins: [], filters: [keep, slow],\n"
        " keep: {plugin: 'nav2_costmap_2d::KeepoutFilter', filter_info_topic: /keep_info},\n"
        " slow: {plugin: 'nav2_costmap_2d::SpeedFilter', filter_info_topic: /slow_info}}}}\n"
    )
    return parse_nav2_costmap((costmap + nodes).encode())


KEEP = "keep_server topic_name: keep_mask, yaml_filename: keep.yaml"
SLOW = "slow_server topic_name: slow_mask, yaml_filename: slow.yaml"
FILTER_FILES: dict[str, tuple[str, tuple[tuple[str | None, int], ...], str]] = {
    "as documented": (
        (f"{KEEP}\n{SLOW}\nkeep_info type: 0, filter_info_topic: /keep_info, mask_topic: /keep_mask\n"
        "slow_info type: 2, filter_info_topic: /slow_info, mask_topic: /slow_mask"),
        (("keep.yaml", 0), ("slow.yaml", 2)),
        "",
    ),
    "both on one topic": (  # navigation2_tutorials#66
        (f"{KEEP}\n{SLOW}\nkeep_info type: 0, filter_info_topic: /slow_info, mask_topic: /keep_mask\n"
        "slow_info type: 1, filter_info_topic: /slow_info, mask_topic: /slow_mask"),
        ((None, 0), ("slow.yaml", 1)),
        "global_costmap.slow: Not only slow_info but also keep_info has the filter_info_topic 'slow_info'",
    ),
    "a speed limit of the keepout's type": (  # SpeedFilter::filterInfoCallback
        f"{SLOW}\nslow_info type: 0, filter_info_topic: /slow_info, mask_topic: /slow_mask",
        ((None, 0), (None, 1)),
        "global_costmap.slow: slow_info states the type 0, where a speed filter needs 1 or 2: as in Nav2",
    ),
    "a keepout with a base": (  # navigation2#4892; KeepoutFilter::filterInfoCallback
        f"{KEEP}\nkeep_info type: 1, filter_info_topic: /keep_info, mask_topic: /keep_mask, base: 100.0",
        (("keep.yaml", 1), (None, 1)),
        "keep_info states a base of 100 and a multiplier of 1, which a keepout filter does not use",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FILTER_FILES)
def test_the_servers_of_filters_are_matched_as_in_nav2(name: str) -> None:
    info, expected, said = FILTER_FILES[name]
    found = filters(info)
    assert tuple((filter_.mask, filter_.type) for filter_ in found.filters) == expected
    noted = [note for note in found.notes if "keep" in note or "slow" in note]
    assert noted == [] if not said else noted[0].startswith(said) and len(noted) == 1
