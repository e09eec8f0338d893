"""Parameter tables of the planner and the path follower, with Nav2's names and defaults.

Sources: nav2_navfn_planner (navfn_planner.cpp, navfn.hpp) and the documentation of Nav2's Regulated Pure Pursuit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from mapper.core.parameter import check_fields, flag, number, table_of


@dataclass(frozen=True, slots=True)
class PlannerConfig:
    """Parameters of the planner. Raises :class:`mapper.core.errors.ConfigError` for an impossible value."""

    # fmt: off
    use_astar: bool = flag(
        "A*", "planner", False, "Whether the search prefers cells towards the goal (A*, not Dijkstra).",
    )
    allow_unknown: bool = flag(
        "Allow unknown", "planner", True, "Whether the path may cross cells without information.",
    )
    tolerance: float = number(
        "Tolerance", "planner", 0.5, "How far from an occupied goal the path may end.", "m", 0.0, 10.0, 0.05,
    )
    neutral_cost: float = number(
        "Neutral cost", "planner", 50.0, "Cost of a step onto a free cell.", "", 1.0, 100.0, 1.0,
    )
    cost_factor: float = number(
        "Cost factor", "planner", 0.8, "How much the cost of a cell adds to that of a step onto it.",
        "", 0.0, 3.0, 0.05,
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True)
class PursuitConfig:
    """Parameters of the path follower. Raises the errors of :class:`PlannerConfig`."""

    # fmt: off
    desired_linear_vel: float = number("Speed", "pursuit", 0.5, "Maximum linear velocity.", "m/s", 0.01, 5.0, 0.01)
    lookahead_dist: float = number(
        "Lookahead distance", "pursuit", 0.6, "How far ahead on the path the robot aims.", "m", 0.05, 5.0, 0.05,
    )
    use_regulated_linear_velocity_scaling: bool = flag(
        "Slow down in curves", "pursuit", True, "Whether the robot is slower where the curve is narrow.",
    )
    regulated_linear_scaling_min_radius: float = number(
        "Slow-down radius", "pursuit", 0.9, "Radius of a curve below which the robot is slower.", "m", 0.01, 10.0, 0.05,
    )
    regulated_linear_scaling_min_speed: float = number(
        "Minimum speed in curves", "pursuit", 0.25, "The robot is not slower than this because of a curve.",
        "m/s", 0.0, 5.0, 0.01,
    )
    approach_velocity_scaling_dist: float = number(
        "Approach distance", "pursuit", 0.6, "Distance from the end of the path within which the robot is slower.",
        "m", 0.01, 10.0, 0.05,
    )
    min_approach_linear_velocity: float = number(
        "Minimum approach speed", "pursuit", 0.05, "The robot is not slower than this because the end is near.",
        "m/s", 0.01, 5.0, 0.01,
    )
    use_rotate_to_heading: bool = flag(
        "Rotate to heading", "pursuit", True,
        "Whether the robot turns on the spot where the path is far from its heading.",
    )
    rotate_to_heading_min_angle: float = number(
        "Rotation threshold", "pursuit", 0.785, "Angle to the point ahead from which the robot turns on the spot.",
        "rad", 0.01, math.pi, 0.01,
    )
    rotate_to_heading_angular_vel: float = number(
        "Rotation speed", "pursuit", 1.8, "Angular velocity of a turn on the spot.", "rad/s", 0.01, 10.0, 0.01,
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)


PLANNER_PARAMETERS = table_of(PlannerConfig)
PURSUIT_PARAMETERS = table_of(PursuitConfig)
