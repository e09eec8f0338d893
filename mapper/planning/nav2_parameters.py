"""Parameters of the planner and of the path's follower in a Nav2 parameter file: NavFn, Regulated Pure Pursuit.

Source: the Nav2 documentation, Planner Server, NavFn Planner, Controller Server and Regulated Pure Pursuit.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import asdict, replace
from typing import Any

import yaml

from mapper.core.errors import ConfigError
from mapper.core.parameter import Parameter
from mapper.io.ros_parameters import find_node, parse_ros_parameters
from mapper.planning.parameters import PLANNER_PARAMETERS, PURSUIT_PARAMETERS, PlannerConfig, PursuitConfig

NODE = "planner_server"
CONTROLLER = "controller_server"
_RENAMED = {"max_linear_vel": "desired_linear_vel"}  #: the name since the release after Kilted, and the one before
_NAMES = ("tolerance", "use_astar", "allow_unknown")  #: the other two rows are constants in Nav2
_WITHOUT_EFFECT = frozenset(("plugin", "use_final_approach_orientation"))
#: What Nav2's follower has besides: slowing near obstacles, collisions, lookahead by speed, reversing.
_NOT_OF_PURSUIT = frozenset((
    "plugin", "min_lookahead_dist", "max_lookahead_dist", "lookahead_time", "use_velocity_scaled_lookahead_dist",
    "transform_tolerance", "use_collision_detection", "max_allowed_time_to_collision_up_to_carrot",
    "use_cost_regulated_linear_velocity_scaling", "cost_scaling_dist", "cost_scaling_gain",
    "inflation_cost_scaling_factor", "regulated_linear_scaling_max_radius", "use_fixed_curvature_lookahead",
    "curvature_lookahead_dist", "allow_reversing", "max_angular_accel", "max_robot_pose_search_dist",
    "interpolate_curvature_after_goal", "use_cancel_deceleration", "cancel_deceleration", "use_interpolation",
    "min_distance_to_obstacle", "stateful", "use_path_aware_obstacle_distance",
))  # fmt: skip


def parse_nav2_planner(data: bytes) -> PlannerConfig:
    """Return the parameters of the first NavFn among ``planner_server``'s ``planner_plugins``.

    Nav2's defaults where the file has none. Raises :class:`ConfigError`, which names the parameter with its path, for
    an unknown name and an impossible value, and what :func:`mapper.io.ros_parameters.parse_ros_parameters` raises.
    """
    return replace(
        PlannerConfig(), **_plugin(data, NODE, "planner_plugins", "NavfnPlanner", _TABLES[0], _WITHOUT_EFFECT)
    )


def parse_nav2_pursuit(data: bytes) -> PursuitConfig:
    """Return the parameters of the first Regulated Pure Pursuit among ``controller_server``'s ``controller_plugins``.

    Defaults, and errors, as :func:`parse_nav2_planner` has them.
    """
    kind = "RegulatedPurePursuitController"
    return replace(
        PursuitConfig(), **_plugin(data, CONTROLLER, "controller_plugins", kind, _TABLES[1], _NOT_OF_PURSUIT)
    )


def nav2_path_yaml(planner: PlannerConfig, pursuit: PursuitConfig) -> str:
    """Return a parameter file with both, as the functions above read it."""
    navfn = {"plugin": "nav2_navfn_planner::NavfnPlanner", **{name: getattr(planner, name) for name in _NAMES}}
    follower = "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController"
    nodes: dict[str, Any] = {
        NODE: {"planner_plugins": ["GridBased"], "GridBased": navfn},
        CONTROLLER: {"controller_plugins": ["FollowPath"], "FollowPath": {"plugin": follower, **asdict(pursuit)}},
    }
    return yaml.safe_dump({name: {"ros__parameters": block} for name, block in nodes.items()}, sort_keys=False)


_TABLES = tuple(row for row in PLANNER_PARAMETERS if row.name in _NAMES), PURSUIT_PARAMETERS


def _plugin(
    data: bytes, node: str, key: str, kind: str, table: tuple[Parameter, ...], without_effect: Collection[str]
) -> dict[str, Any]:
    """Return the values that a file has for the first plugin of a kind in a node's list; none where it has none."""
    found = find_node(parse_ros_parameters(data), (node,))
    names = found[1].get(key, []) if found else []
    if not isinstance(names, list):
        raise ConfigError("nav2.plugins", f"{node}.{key} must be a list of names, not {names!r:.80}.")
    rows = {row.name: row for row in table}
    for name in names:
        block = found[1].get(name) if found and isinstance(name, str) else None
        if not isinstance(block, dict) or kind not in str(block.get("plugin")):
            continue
        values: dict[str, Any] = {}
        for given, value in block.items():
            parameter = _RENAMED.get(given, given)
            if parameter in rows:
                try:
                    values[parameter] = rows[parameter].check(value)
                except ConfigError as error:
                    raise ConfigError("nav2.value", f"{node}.{name}.{given}: {error.message}") from error
            elif parameter not in without_effect:
                raise ConfigError("nav2.unknown", f"{node}.{name}: There is no parameter {given!r:.80}.")
        return values
    return {}
