"""The tables of parameters of the planner and of the path's follower, with Nav2's names and defaults.

Sources: nav2_navfn_planner (navfn_planner.cpp, navfn.hpp) and the documentation of Nav2's Regulated Pure Pursuit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from mapper.core.parameter import Parameter, check_fields, check_table


def _flag(name: str, label: str, group: str, initial: bool, sentence: str) -> Parameter:
    return Parameter(name, label, group, "flag", initial, sentence)


def _number(
    name: str, label: str, group: str, initial: float, sentence: str, unit: str, bounds: tuple[float, float, float]
) -> Parameter:
    low, high, step = bounds
    return Parameter(name, label, group, "number", initial, sentence, unit, low, high, step)


PLANNER_PARAMETERS: tuple[Parameter, ...] = (
    _flag("use_astar", "A*", "planner", False, "Whether the search prefers cells towards the goal (A*, not Dijkstra)."),
    _flag("allow_unknown", "Through unknown", "planner", True, "Whether the path may cross cells without information."),
    _number("tolerance", "Tolerance", "planner", 0.5, "How far from an occupied goal the path may end.", "m",
            (0.0, 10.0, 0.05)),
    _number("neutral_cost", "Neutral cost", "planner", 50.0, "Cost of a step onto a free cell.", "", (1.0, 100.0, 1.0)),
    _number("cost_factor", "Cost factor", "planner", 0.8, "How much the cost of a cell adds to that of a step onto it.",
            "", (0.0, 3.0, 0.05)),
)  # fmt: skip

PURSUIT_PARAMETERS: tuple[Parameter, ...] = (
    _number("desired_linear_vel", "Speed", "pursuit", 0.5, "Greatest linear velocity.", "m/s", (0.01, 5.0, 0.01)),
    _number("lookahead_dist", "Lookahead distance", "pursuit", 0.6, "How far ahead on the path the robot aims.", "m",
            (0.05, 5.0, 0.05)),
    _flag("use_regulated_linear_velocity_scaling", "Slower in curves", "pursuit", True,
          "Whether the robot is slower where the curve is narrow."),
    _number("regulated_linear_scaling_min_radius", "Narrow radius", "pursuit", 0.9,
            "Radius of a curve below which the robot is slower.", "m", (0.01, 10.0, 0.05)),
    _number("regulated_linear_scaling_min_speed", "Least speed in curves", "pursuit", 0.25,
            "The robot is not slower than this because of a curve.", "m/s", (0.0, 5.0, 0.01)),
    _number("approach_velocity_scaling_dist", "Approach distance", "pursuit", 0.6,
            "Distance from the end of the path within which the robot is slower.", "m", (0.01, 10.0, 0.05)),
    _number("min_approach_linear_velocity", "Least speed of approach", "pursuit", 0.05,
            "The robot is not slower than this because the end is near.", "m/s", (0.01, 5.0, 0.01)),
    _flag("use_rotate_to_heading", "Turn first", "pursuit", True,
          "Whether the robot turns on the spot where the path is far from its heading."),
    _number("rotate_to_heading_min_angle", "Angle of turning", "pursuit", 0.785,
            "Angle to the point ahead from which the robot turns on the spot.", "rad", (0.01, math.pi, 0.01)),
    _number("rotate_to_heading_angular_vel", "Speed of turning", "pursuit", 1.8,
            "Angular velocity of a turn on the spot.", "rad/s", (0.01, 10.0, 0.01)),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class PlannerConfig:
    """Parameters of the planner. Raises :class:`mapper.core.errors.ConfigError` for an impossible value."""

    use_astar: bool = False
    allow_unknown: bool = True
    tolerance: float = 0.5
    neutral_cost: float = 50.0
    cost_factor: float = 0.8

    def __post_init__(self) -> None:
        check_fields(self, PLANNER_PARAMETERS)


@dataclass(frozen=True, slots=True)
class PursuitConfig:
    """Parameters of the follower of a path. Raises as :class:`PlannerConfig`."""

    desired_linear_vel: float = 0.5
    lookahead_dist: float = 0.6
    use_regulated_linear_velocity_scaling: bool = True
    regulated_linear_scaling_min_radius: float = 0.9
    regulated_linear_scaling_min_speed: float = 0.25
    approach_velocity_scaling_dist: float = 0.6
    min_approach_linear_velocity: float = 0.05
    use_rotate_to_heading: bool = True
    rotate_to_heading_min_angle: float = 0.785
    rotate_to_heading_angular_vel: float = 1.8

    def __post_init__(self) -> None:
        check_fields(self, PURSUIT_PARAMETERS)


check_table(PlannerConfig, PLANNER_PARAMETERS)
check_table(PursuitConfig, PURSUIT_PARAMETERS)
