"""The comparison of Nav2's sources with the names that are known here, on sources in the forms that Nav2 has."""

from __future__ import annotations

from pathlib import Path

import pytest

from mapper.tools.nav2_names import declared, main

CALLS = """
  declareParameter("enabled", rclcpp::ParameterValue(true));
  declareParameter(source + "." + "topic", rclcpp::ParameterValue(source));
  declare_parameter_if_not_declared(
    node, plugin_name_ + ".lookahead_dist", rclcpp::ParameterValue(0.6));
  radius_ = node->declare_or_get_parameter(name_ + "." + "inflation_radius", 0.55);
  topic_ = node->declare_or_get_parameter<std::string>(
    "plan_topic", "plan");
  nav2::declare_parameter_if_not_declared(
    node, default_ids_[i] + ".plugin", rclcpp::ParameterValue(default_types_[i]));
  declare_parameter("footprint", rclcpp::ParameterValue(std::string("[]")));
  add_parameter("initial_pose.x", rclcpp::ParameterValue(0.0), "Of the robot, in the map", "No others");
  void declareParameter(const std::string & param_name, const rclcpp::ParameterValue & value);
  node->get_parameter(name_ + "." + "other", other_);
"""


def test_names_are_those_that_a_node_or_a_plugin_declares_for_itself() -> None:
    assert list(declared(CALLS)) == [
        ("enabled", False),
        ("topic", True),
        ("lookahead_dist", False),
        ("inflation_radius", False),
        ("plan_topic", False),
        ("footprint", False),
        ("initial_pose.x", False),
    ]


def test_what_is_lacking_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    layer, amcl = (
        tmp_path / path for path in ("nav2_costmap_2d/plugins/inflation_layer.cpp", "nav2_amcl/src/amcl_node.cpp")
    )
    for path in (layer, amcl):
        path.parent.mkdir(parents=True)
    layer.write_text('declareParameter("cost_scaling_factor", 1.0);\ndeclareParameter("enabled", true);\n')
    amcl.write_text('add_parameter("max_beams", 60);\nadd_parameter("initial_pose.yaw", 0.0);\n')
    assert main([str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert f"{tmp_path.name}: nav2_amcl/src/amcl_node.cpp: 2 declared, lacking: –" in said
    assert f"{tmp_path.name}: no nav2_planner/src/planner_server.cpp" in said
    (known,) = [line for line in said.splitlines() if line.startswith("known, and declared in none")]
    assert {"inflation_radius", "scan_topic"} <= {*known.split()}
    assert not {"cost_scaling_factor", "initial_pose", "obstacle_max_range"} & {*known.split()}
    layer.write_text('declareParameter("inflation_radios", 1.0);\n')
    assert main([str(tmp_path)]) == 1
    assert "inflation_layer.cpp: 1 declared, lacking: inflation_radios" in capsys.readouterr().out
