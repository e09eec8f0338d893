"""Nav2's parameter files: as its documentation writes them, there and back, and files with errors."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from mapper.core.errors import ConfigError, LimitError, MapperError, ReadError
from mapper.costmap.build import build_costmap
from mapper.costmap.nav2.reading import parse_nav2_costmap
from mapper.costmap.nav2.writing import nav2_yaml
from mapper.costmap.parameters import (
    InflationConfig,
    NamedSource,
    ObstacleConfig,
    SourceConfig,
    StaticConfig,
    VoxelConfig,
)
from mapper.grid import GridGeometry

FILE = b"""
amcl:
  ros__parameters:
    alpha1: 0.2
local_costmap:
  local_costmap:
    ros__parameters:
      rolling_window: true
      width: 3
      footprint: "[[0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.3, -0.2]]"
      plugins: ["voxel_layer", "inflation_layer"]
      voxel_layer:
        plugin: "nav2_costmap_2d::VoxelLayer"
        z_voxels: 16
        mark_threshold: 2
        observation_sources: scan
        scan: {topic: /scan, clearing: True, max_obstacle_height: 1.5}
      inflation_layer: {plugin: "nav2_costmap_2d::InflationLayer"}
global_costmap:
  global_costmap:
    ros__parameters:
      update_frequency: 1.0
      global_frame: map
      robot_radius: 0.22
      resolution: 0.05
      track_unknown_space: true
      lethal_cost_threshold: 65
      plugins: ["static_layer", "obstacle_layer", "inflation_layer"]
      filters: ["keepout_filter"]
      keepout_filter: {plugin: "nav2_costmap_2d::KeepoutFilter", filter_info_topic: "/info"}
      obstacle_layer:
        plugin: "nav2_costmap_2d::ObstacleLayer"
        enabled: True
        combination_method: 0
        observation_sources: scan
        scan:
          topic: /scan
          marking: True
          clearing: True
          raytrace_max_range: 4.5
          obstacle_max_range: 3.5
          data_type: "LaserScan"
      static_layer:
        plugin: "nav2_costmap_2d::StaticLayer"
        map_subscribe_transient_local: True
      inflation_layer:
        plugin: "nav2_costmap_2d::InflationLayer"
        cost_scaling_factor: 3.0
        inflation_radius: 0.7
      always_send_full_costmap: True
"""


def test_the_global_costmap_of_a_whole_file() -> None:
    found = parse_nav2_costmap(FILE)
    assert (found.node, found.general.robot_radius, found.general.track_unknown_space) == ("global_costmap", 0.22, True)
    assert [layer.name for layer in found.layers] == ["static_layer", "obstacle_layer", "inflation_layer"]
    static, obstacle, inflation = (layer.config for layer in found.layers)
    assert static == StaticConfig(lethal_cost_threshold=65)
    scans = SourceConfig(clearing=True, raytrace_max_range=4.5, obstacle_max_range=3.5)
    assert isinstance(obstacle, ObstacleConfig)
    assert obstacle.sources == (NamedSource("scan", scans, "/scan"),)
    assert obstacle.combination_method == "overwrite"
    assert inflation == InflationConfig(inflation_radius=0.7, cost_scaling_factor=3.0)
    assert [(one.name, one.kind, one.mask) for one in found.filters] == [("keepout_filter", "keepout", None)]
    assert "global_costmap.update_frequency" in found.unused


def test_the_local_costmap_with_a_footprint() -> None:
    found = parse_nav2_costmap(FILE, "local_costmap")
    scans = NamedSource("scan", SourceConfig(clearing=True, max_obstacle_height=1.5), "/scan")
    assert found.layers[0].config == VoxelConfig(z_voxels=16, mark_threshold=2, clearing=False, sources=(scans,))
    assert found.outline.inscribed_radius == pytest.approx(0.21)


@pytest.mark.parametrize("node", ["global_costmap", "local_costmap"])
def test_what_is_written_is_read_back(node: str) -> None:
    found = parse_nav2_costmap(FILE, node)
    again = parse_nav2_costmap(nav2_yaml(found, 0.05).encode())
    assert replace(again, notes=()) == replace(found, notes=())
    assert again.unused == found.unused
    assert not any("max_obstacle_height" in note for note in again.notes)  # Nav2 has 0 m for a source without one


def test_what_changes_no_cost_is_said_and_written_again() -> None:
    two = FILE.replace(b"observation_sources: scan\n        scan:", b"observation_sources: front rear\n        front:")
    two = two.replace(
        b"      static_layer:\n", b"        rear: {topic: /rear, clearing: true}\n      static_layer:\n", 1
    )
    found = parse_nav2_costmap(two)
    assert set(found.unused) == {
        "global_costmap.update_frequency", "global_costmap.global_frame", "global_costmap.always_send_full_costmap",
        "global_costmap.static_layer.map_subscribe_transient_local",
    }  # fmt: skip
    text = nav2_yaml(found, 0.05)
    values = yaml.safe_load(text)["global_costmap"]["global_costmap"]["ros__parameters"]
    assert (values["update_frequency"], values["global_frame"], values["resolution"]) == (1.0, "map", 0.05)
    layer = values["obstacle_layer"]
    assert layer["observation_sources"] == "front rear"
    assert (layer["front"]["topic"], layer["front"]["raytrace_max_range"]) == ("/scan", 4.5)
    assert [layer["rear"][key] for key in ("topic", "clearing", "raytrace_max_range")] == ["/rear", True, 3.0]
    assert values["static_layer"]["map_subscribe_transient_local"] is True
    assert replace(parse_nav2_costmap(text.encode()), notes=()) == replace(found, notes=())


def test_a_costmap_is_built_from_it() -> None:
    values = np.zeros((40, 50), dtype=np.int8)
    values[20, 25] = 70
    built = build_costmap(GridGeometry(0.05, 40, 50), values, parse_nav2_costmap(FILE))
    built.costmap.update()
    assert built.costmap.costs[20, 25] == 254, "70 is lethal from a threshold of 65 on"
    assert built.costmap.costs[20, 29] == 253
    assert 0 < built.costmap.costs[20, 35] < 253
    assert len(built.obstacles) == 1


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        (("cost_scaling_factor: 3.0", "cost_scaling_factor: -3.0"), ConfigError,
         r"global_costmap\.inflation_layer\.cost_scaling_factor: .* between 0 and 100 1/m, not -3\.0"),
        (("inflation_radius: 0.7", "inflation_radius: wide"), ConfigError, "must be a finite number, not 'wide'"),
        (("combination_method: 0", "combination_method: 7"), ConfigError, "must be 0, 1 or 2, not 7"),
        (('plugins: ["static_layer"', 'plugins: ["other"'), ConfigError, r"global_costmap\.other: .* no 'plugin'"),
        (("robot_radius: 0.22", 'footprint: "[[1, 1], [-1, -1], [1, 101]]"'), ConfigError, "within 100 m"),
        (("amcl:", "amcl: &a"), None, ""),
        (("alpha1: 0.2", "alpha1: [0.2"), ReadError, "malformed in line"),
    ],
)  # fmt: skip
def test_a_file_with_an_error_is_refused_with_the_place(
    change: tuple[str, str], error: type[MapperError] | None, said: str
) -> None:
    data = FILE.replace(change[0].encode(), change[1].encode())
    assert data != FILE
    if error is None:
        parse_nav2_costmap(data)
        return
    with pytest.raises(error, match=said):
        parse_nav2_costmap(data)


def test_files_that_are_none() -> None:
    with pytest.raises(ReadError, match="no costmap: no global_costmap or local_costmap"):
        parse_nav2_costmap(b"amcl:\n  ros__parameters:\n    alpha1: 0.2\n")
    with pytest.raises(ReadError, match="no names with values"):
        parse_nav2_costmap(b"- 1\n")
    with pytest.raises(ReadError, match="not UTF-8"):
        parse_nav2_costmap(b"\xff\xfe\xfd")
    with pytest.raises(ReadError, match="'x' is within itself"):
        parse_nav2_costmap(b"a: &x [*x]\n")
    with pytest.raises(ReadError, match="deeper than"):
        parse_nav2_costmap(b"[" * 60 + b"]" * 60)
    with pytest.raises(LimitError):
        parse_nav2_costmap(b"#" * (1 << 20) + b"\n")
