"""Names of the parameters declared by Nav2's costmaps, layers, AMCL, and planner and controller servers.

Source: the calls of declare_parameter in the main branch, between Iron and Kilted, of navigation2's costmap_2d_ros.cpp,
static_layer.cpp, obstacle_layer.cpp, voxel_layer.cpp, denoise_layer.cpp, inflation_layer.cpp,
plugin_container_layer.cpp, costmap_filter.cpp, keepout_filter.cpp, speed_filter.cpp, binary_filter.cpp,
planner_server.cpp, controller_server.cpp and the parameter_handler.cpp of both, navfn_planner.cpp,
nav2_regulated_pure_pursuit_controller's parameter_handler.cpp and amcl_node.cpp, plus the names of older and newer
releases. Defaults in :mod:`mapper.costmap.parameters`, :mod:`mapper.planning.parameters` and
:mod:`mapper.localization.parameters` were also compared with these. A name missing from these tables gets a note and
has no effect, because rclcpp ignores undeclared parameters. :mod:`mapper.tools.nav2_names` compares the tables with the
sources of a release.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Collection

from mapper.core.errors import ConfigError
from mapper.core.parameter import Parameter

RELEASES = "Foxy to Kilted"


def _names(text: str) -> frozenset[str]:
    return frozenset(text.split())


#: of every node: rclcpp's, nav2_util's LifecycleNode's, and those of nodes that offer services
NODE = _names(
    "use_sim_time qos_overrides start_type_description_service bond_heartbeat_period autostart_node "
    "introspection_mode service_introspection_mode allow_parameter_qos_overrides"
)
COSTMAP = _names(
    "always_send_full_costmap map_vis_z footprint_padding footprint global_frame height width lethal_cost_threshold "
    "inscribed_obstacle_cost_value observation_sources origin_x origin_y plugins filters publish_frequency resolution "
    "robot_base_frame robot_radius rolling_window track_unknown_space transform_tolerance initial_transform_timeout "
    "trinary_costmap unknown_cost_value update_frequency use_maximum subscribe_to_stamped_footprint "
    "map_topic clearable_layers plugin_names plugin_types"  # these four up to Foxy, the last two up to Eloquent
)
LAYER = _names("plugin enabled")  #: of every layer
_OBSTACLE = LAYER | _names(
    "footprint_clearing_enabled restore_cleared_footprint min_obstacle_height max_obstacle_height combination_method "
    "observation_sources tf_filter_tolerance"
)
LAYERS = {
    "StaticLayer": LAYER
    | _names(
        "subscribe_to_updates map_subscribe_transient_local transform_tolerance map_topic footprint_clearing_enabled "
        "restore_cleared_footprint"
    ),
    "ObstacleLayer": _OBSTACLE,
    "VoxelLayer": _OBSTACLE
    | _names("z_voxels origin_z z_resolution unknown_threshold mark_threshold publish_voxel_map"),
    "PluginContainerLayer": LAYER | _names("plugins combination_method"),
    "DenoiseLayer": LAYER | _names("minimal_group_size group_connectivity_type"),
    "InflationLayer": LAYER
    | _names("inflation_radius cost_scaling_factor inflate_unknown inflate_around_unknown num_threads"),
}
_FILTER = LAYER | _names("filter_info_topic transform_tolerance")
FILTERS = {
    "KeepoutFilter": _FILTER | _names("override_lethal_cost lethal_override_cost"),
    "SpeedFilter": _FILTER | _names("speed_limit_topic"),
    "BinaryFilter": _FILTER | _names("default_state binary_state_topic flip_threshold"),
}
SOURCE = _names(
    "topic sensor_frame observation_persistence expected_update_rate data_type min_obstacle_height "
    "max_obstacle_height inf_is_valid marking clearing obstacle_max_range obstacle_min_range raytrace_max_range "
    "raytrace_min_range transport_type"
)  #: of one observation source
#: Names changed by later releases: the old one, the new one, and the first release with the new one.
RENAMED = {
    "obstacle_range": ("obstacle_max_range", "Galactic"),
    "raytrace_range": ("raytrace_max_range", "Galactic"),
}
#: Integer parameters of costmaps; all other numbers are doubles.
WHOLE = _names(
    "lethal_cost_threshold inscribed_obstacle_cost_value unknown_cost_value width height z_voxels mark_threshold "
    "unknown_threshold minimal_group_size group_connectivity_type combination_method num_threads"
)
PLANNER_SERVER = _names(
    "planner_plugins expected_planner_frequency costmap_update_timeout allow_partial_planning "
    "action_server_result_timeout "  # up to Jazzy
    "planner_plugin planner_plugin_ids planner_plugin_types"  # these up to Foxy
)
CONTROLLER_SERVER = _names(
    "controller_plugins controller_frequency transform_tolerance min_x_velocity_threshold min_y_velocity_threshold "
    "min_theta_velocity_threshold speed_limit_topic failure_tolerance use_realtime_priority publish_zero_velocity "
    "costmap_update_timeout odom_topic odom_duration progress_checker_plugins goal_checker_plugins "
    "action_server_result_timeout enable_stamped_cmd_vel "
    "interpolate_curvature_after_goal max_robot_pose_search_dist prune_distance enforce_path_inversion "
    "inversion_xy_tolerance inversion_yaw_tolerance path_handler_plugins "  # path handler, after Kilted
    "progress_checker_plugin goal_checker_plugin controller_plugin_ids controller_plugin_types"  # older names
)
NAVFN = _names("plugin tolerance use_astar allow_unknown use_final_approach_orientation")
PURSUIT = _names(
    "plugin desired_linear_vel max_linear_vel lookahead_dist min_lookahead_dist max_lookahead_dist lookahead_time "
    "rotate_to_heading_angular_vel transform_tolerance use_velocity_scaled_lookahead_dist min_approach_linear_velocity "
    "approach_velocity_scaling_dist max_allowed_time_to_collision_up_to_carrot use_regulated_linear_velocity_scaling "
    "use_cost_regulated_linear_velocity_scaling cost_scaling_dist cost_scaling_gain inflation_cost_scaling_factor "
    "regulated_linear_scaling_min_radius regulated_linear_scaling_max_radius regulated_linear_scaling_min_speed "
    "use_fixed_curvature_lookahead curvature_lookahead_dist use_rotate_to_heading rotate_to_heading_min_angle "
    "max_angular_accel max_linear_accel max_linear_decel allow_reversing use_collision_detection "
    "max_robot_pose_search_dist interpolate_curvature_after_goal use_cancel_deceleration cancel_deceleration "
    "use_interpolation use_approach_linear_velocity_scaling goal_dist_tol min_distance_to_obstacle stateful "
    "use_path_aware_obstacle_distance"
)
#: of AMCL, except those that affect the estimate (in :mod:`mapper.localization.parameters`)
AMCL = _names(
    "always_reset_initial_pose base_frame_id beam_skip_distance beam_skip_error_threshold beam_skip_threshold "
    "do_beamskip first_map_only freespace_downsampling force_update_after_initialpose force_update_after_set_map "
    "global_frame_id gui_publish_rate initial_cov_aa initial_cov_xx initial_cov_yy initial_pose initial_pose_a "
    "initial_pose_x initial_pose_y map_topic odom_frame_id random_seed save_pose_rate scan_topic set_initial_pose "
    "tf_broadcast transform_tolerance use_map_topic std_warn_level_enabled"
)


_PLACEHOLDER = re.compile(r"[A-Z][A-Z0-9]*(?:_[A-Z0-9]+)+")


def undeclared(where: str, name: str, declared: Collection[str]) -> str:
    """Return the sentence on a parameter that Nav2 does not declare; ``where`` is the path of its node or layer."""
    close = difflib.get_close_matches(name[:100], [*declared], 1, 0.8)
    meant = f" (did you mean {close[0]!r}?)" if close else ""
    return f"{where}: Nav2 ({RELEASES}) declares no parameter {name!r:.80}{meant}; it has no effect there, nor here."


def not_built(where: str, plugin: object, in_place: str) -> str:
    """Return the sentence on a server plugin that is not supported, and its substitute."""
    return f"{where}: {str(plugin)!r:.80} is not built here; {in_place}."


def checked(row: Parameter, value: object, where: str, notes: list[str]) -> float | str | bool:
    """Return a parameter file's value converted to our row; ``where`` is its path in the file.

    A number beyond the supported range, such as a maximum height of 1000 m or .inf, is no error: it is clamped, with a
    note. Raises :class:`ConfigError`, naming the path, for any other invalid value.
    """
    notes += wrong_type(value, where, is_whole=row.name in WHOLE)
    value = within(row, value, where, notes)
    try:
        return row.check(value)
    except ConfigError as error:
        raise ConfigError("nav2.value", f"{where}: {error.message}{_FILLED_IN * is_filled_in(value)}") from error


def wrong_type(value: object, where: str, *, is_whole: bool) -> list[str]:
    """Return a note on a number with a decimal point if Nav2 declares an integer, or without one if it declares a
    double.

    Since Galactic, rclcpp refuses to set a parameter to a value of another type.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or isinstance(value, int) == is_whole:
        return []
    if is_whole and not float(value).is_integer():
        return [f"{where} is {value:g}, where Nav2 declares an integer, and does not start: it must be a whole number."]
    written = str(int(value)) if is_whole else f"{value}.0"
    expected = "an integer" if is_whole else "a double"
    return [f"{where} is {value}, where Nav2 declares {expected}, and does not start: write {written}."]


_FILLED_IN = " It is filled in where Nav2 is launched: put the value into the file."


def is_filled_in(value: object) -> bool:
    """Return whether a value is filled in by a launch file, such as ``$(var x)``, ``<x>`` or ``ZONE_ENABLED``."""
    return isinstance(value, str) and ("$(" in value or value.startswith("<") or bool(_PLACEHOLDER.fullmatch(value)))


def switched(value: object, where: str, notes: list[str]) -> bool:
    """Return the value of a filter's ``enabled``; true, with a note, if a launch file fills it in.

    Since Kilted, Nav2's own parameter file has KEEPOUT_ZONE_ENABLED and SPEED_ZONE_ENABLED there, whose launch file
    defaults are true. Raises :class:`ConfigError` for any other invalid value.
    """
    if is_filled_in(value):
        notes.append(f"{where} is {value!s:.80}, which is filled in where Nav2 is launched: true is taken.")
        return True
    if not isinstance(value, bool):
        raise ConfigError("nav2.value", f"{where} must be true or false, not {value!r:.40}.")
    return value


def within(row: Parameter, value: object, where: str, notes: list[str]) -> object:
    """Clamp a number above a row's bounds to the upper one, and one below negative bounds to the lower one.

    A note is added. Other values are returned unchanged.
    """
    if row.kind != "number" or isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
        return value
    nearest = row.high if value > row.high else row.low if value < row.low < 0.0 else value
    if nearest != value:
        beyond = "more than" if value > row.high else "less than"
        used = f"{nearest:g} {row.unit}".rstrip()
        notes.append(f"{where} is {value:g}, {beyond} is computed with here: {used} is taken.")
    return nearest
