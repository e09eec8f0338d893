"""The planner's parameters in Nav2's parameter files."""

import pytest

from mapper.core.errors import ConfigError
from mapper.planning import PlannerConfig
from mapper.planning.nav2_parameters import parse_nav2_planner, parse_nav2_pursuit

FILE = """
planner_server:
  ros__parameters:
    planner_plugins: [Smooth, GridBased]
    Smooth: {plugin: "nav2_smac_planner::SmacPlanner2D", tolerance: 9.0}
    GridBased: {plugin: "nav2_navfn_planner::NavfnPlanner", tolerance: 0.25, use_astar: true, allow_unknown: false}
"""


def test_navfns_parameters_are_read() -> None:
    assert parse_nav2_planner(FILE.encode()) == PlannerConfig(use_astar=True, allow_unknown=False, tolerance=0.25)
    assert parse_nav2_planner(b"amcl: {ros__parameters: {alpha1: 0.1}}") == PlannerConfig()


def test_the_speed_has_two_names() -> None:
    text = "controller_server: {ros__parameters: {controller_plugins: [F], F: {plugin: RegulatedPurePursuitController, "
    for name in ("max_linear_vel", "desired_linear_vel"):
        assert parse_nav2_pursuit(f"{text}{name}: 0.3}}}}}}".encode()).desired_linear_vel == 0.3


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("0.25", "-1", "planner_server.GridBased.tolerance: .*between 0 and 10 m, not -1"),
        ("true", "maybe", "planner_server.GridBased.use_astar: .*true or false"),
        ("use_astar", "use_star", "planner_server.GridBased: There is no parameter 'use_star'"),
        ("[Smooth, GridBased]", "7", "planner_plugins must be a list of names, not 7"),
    ],
)
def test_what_is_refused_names_its_place(old: str, new: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        parse_nav2_planner(FILE.replace(old, new).encode())
