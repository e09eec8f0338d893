"""The parameters of planner and follower in Nav2's parameter files."""

from dataclasses import replace

import pytest
import yaml

from mapper.core.errors import ConfigError
from mapper.planning import PlannerConfig, PursuitConfig
from mapper.planning.nav2_parameters import Nav2Path, nav2_path_yaml
from mapper.planning.parameters import PURSUIT_PARAMETERS
from tests.mapper.planning.nav2_file import parse_nav2_path

FILE = """
planner_server:
  ros__parameters:
    expected_planner_frequency: 20.0
    planner_plugins: [Smooth, GridBased]
    Smooth: {plugin: "nav2_smac_planner::SmacPlanner2D", tolerance: 9.0}
    GridBased: {plugin: "nav2_navfn_planner::NavfnPlanner", tolerance: 0.25, use_astar: true, allow_unknown: false}
"""
CONTROLLER = """
controller_server:
  ros__parameters:
    controller_frequency: 20.0
    progress_checker_plugins: [progress]
    controller_plugins: [FollowPath]
    progress: {plugin: "nav2_controller::SimpleProgressChecker", required_movement_radius: 0.5}
    FollowPath:
      plugin: "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController"
      desired_linear_vel: 0.3
      lookahead_dist: 0.9
      regulated_linear_scaling_min_radius: 1.5
      rotate_to_heading_angular_vel: 1.1
      use_collision_detection: true
      cost_scaling_gain: 0.7
"""


def test_navfns_parameters_are_read() -> None:
    expected = PlannerConfig(use_astar=True, allow_unknown=False, tolerance=0.25)
    assert parse_nav2_path(FILE.encode()).planner == expected
    assert parse_nav2_path(b"amcl: {ros__parameters: {alpha1: 0.1}}") == Nav2Path()


def test_without_a_list_the_planner_is_nav2s_own_default() -> None:
    """planner_server.cpp: default_ids_ and default_types_; the default follower is DWB, which is not built here."""
    text = "planner_server: {ros__parameters: {GridBased: {tolerance: 0.2}}}\n"
    found = parse_nav2_path(
        f"{text}controller_server: {{ros__parameters: {{FollowPath: {{max_vel_x: 1.0}}}}}}".encode()
    )
    assert (found.planner.tolerance, found.planner_name, found.pursuit) == (0.2, "GridBased", PursuitConfig())
    assert found.unused == ("controller_server.FollowPath",)
    other = parse_nav2_path(text.replace("GridBased:", "planner_plugins: [A], A:").encode())
    assert other.planner == PlannerConfig()


def test_names_that_the_servers_do_not_declare_have_a_note() -> None:
    text = FILE.replace("expected_planner_frequency", "expected_planer_frequency")
    text += CONTROLLER.replace(
        "    progress_checker_plugins", "    bond_heartbeat_period: 0.1\n    hurry: 1\n    progress_checker_plugins"
    )
    (planner, controller) = parse_nav2_path(text.encode()).notes
    assert "planner_server: Nav2" in planner
    assert "(did you mean 'expected_planner_frequency'?)" in planner
    assert "controller_server: Nav2 (Foxy to Kilted) declares no parameter 'hurry'" in controller


def test_the_speed_has_two_names() -> None:
    text = "controller_server: {ros__parameters: {controller_plugins: [F], F: {plugin: RegulatedPurePursuitController, "
    for name in ("max_linear_vel", "desired_linear_vel"):
        assert parse_nav2_path(f"{text}{name}: 0.3}}}}}}".encode()).pursuit.desired_linear_vel == 0.3


def test_what_has_no_effect_is_named_and_written_again() -> None:
    found = parse_nav2_path((FILE + CONTROLLER).encode())
    assert found.pursuit == replace(
        PursuitConfig(),
        desired_linear_vel=0.3,
        lookahead_dist=0.9,
        regulated_linear_scaling_min_radius=1.5,
        rotate_to_heading_angular_vel=1.1,
    )
    assert set(found.unused) == {
        "planner_server.expected_planner_frequency",
        "planner_server.Smooth",
        "controller_server.controller_frequency",
        "controller_server.progress_checker_plugins",
        "controller_server.progress",
        "controller_server.FollowPath.use_collision_detection",
        "controller_server.FollowPath.cost_scaling_gain",
    }
    changed = replace(found, planner=replace(found.planner, tolerance=0.75))
    text = nav2_path_yaml(changed)
    assert parse_nav2_path(text.encode()) == changed
    given, written = yaml.safe_load(FILE + CONTROLLER), yaml.safe_load(text)
    given["planner_server"]["ros__parameters"]["GridBased"]["tolerance"] = 0.75
    for node, block in given.items():
        for name, value in block["ros__parameters"].items():
            now = written[node]["ros__parameters"][name]
            # The follower's parameters that the file leaves at their defaults are written out.
            assert now == value or {key: now[key] for key in value} == value


def test_another_planner_and_controller_stay_in_the_file() -> None:
    text = (FILE + CONTROLLER).replace("nav2_navfn_planner::NavfnPlanner", "a::Planner")
    text = text.replace("nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController", "dwb_core::DWB")
    found = parse_nav2_path(text.encode())
    assert (found.planner, found.pursuit) == (PlannerConfig(), PursuitConfig())
    written = yaml.safe_load(nav2_path_yaml(found))
    planner, controller = (written[node]["ros__parameters"] for node in ("planner_server", "controller_server"))
    assert planner["planner_plugins"] == ["Smooth", "GridBased", "NavFn"]
    assert controller["controller_plugins"] == ["FollowPath", "RegulatedPurePursuit"]
    assert controller["FollowPath"]["plugin"] == "dwb_core::DWB"
    again = parse_nav2_path(nav2_path_yaml(found).encode())
    assert (again.planner_name, again.follower_name, again.unused) == ("NavFn", "RegulatedPurePursuit", found.unused)


def test_an_infinite_lookahead_is_the_longest_that_is_computed_with() -> None:
    found = parse_nav2_path((FILE + CONTROLLER).replace("lookahead_dist: 0.9", "lookahead_dist: .inf").encode())
    (row,) = (row for row in PURSUIT_PARAMETERS if row.name == "lookahead_dist")
    assert found.pursuit.lookahead_dist == row.high
    assert any("FollowPath.lookahead_dist is inf, more than is computed with here" in note for note in found.notes)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("0.25", "-1", "planner_server.GridBased.tolerance: .*between 0 and 10 m, not -1"),
        ("true,", "maybe,", "planner_server.GridBased.use_astar: .*true or false"),
        ("[Smooth, GridBased]", "7", "planner_plugins must be a list of names, not 7"),
        ("[Smooth, GridBased]", "[[Smooth], GridBased]", "planner_plugins must be a list of names, not"),
        ("lookahead_dist: 0.9", "lookahead_dist: .nan", "controller_server.FollowPath.lookahead_dist: "),
        ("[FollowPath]", "{a: 1}", "controller_plugins must be a list of names, not"),
    ],
)
def test_what_is_refused_names_its_place(old: str, new: str, said: str) -> None:
    assert old in FILE + CONTROLLER
    with pytest.raises(ConfigError, match=said):
        parse_nav2_path((FILE + CONTROLLER).replace(old, new).encode())
