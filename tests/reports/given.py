"""Inputs beside the folder of real logs that stand for public reports: what is done with each, and what must come.

The folder ``reports`` beside the one that GRIDBLOOM_TEST_DATA names has them, with a scorer of its own: which share of
the occupied cells lies within 0.12 m of a true wall, and which share of the walls the map has.
"""

from __future__ import annotations

import importlib
import math
import re
import sys
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from typer.testing import CliRunner

from server.cli import app

ROOM = ("costmap", "maps/room.yaml", "--params")
CLOUD = r"40 points\n  box \(-1\.977, -1\.972, -1\.423\) to \(1\.985, 1\.802, 1\.923\)"


@dataclass(frozen=True)
class Given:
    """An input by its path in the folder, and what public report it stands for.

    ``command`` is run with ``options`` behind the path, ``said`` is a pattern of what it prints or refuses, ``unsaid``
    one that must not come. With ``frame``, the pose (x, y, yaw) of the map's frame in the room, a map is due.
    """

    path: str
    source: str
    said: str = ""
    unsaid: str = "poses of trajectory .* drift"
    command: tuple[str, ...] = ("map",)
    options: tuple[str, ...] = ()
    frame: tuple[float, float, float] | None = None

    @property
    def name(self) -> str:
        return " ".join((*self.path.split("/")[1:], *self.options))


START = (1.2, 1.2, 0.0)  #: where the robot of most logs begins, which is where their maps have 0

CASES = (
    Given("logs/base", "none: a run without a fault", frame=START),
    Given(
        "logs/multi_robot_same_frames",
        "create3_sim#211, rosbot_xl_ros#71, navigation2#5449, geometry2#326",
        frame=START,
    ),
    Given(
        "logs/multi_robot_same_frames",
        "the same, its other robot",
        options=("--topic", "/robot2/scan"),
        frame=(3.6, 4.8, 0.0),
    ),
    Given("logs/range_max_per_scan_close", "sick_scan_xd#509", "the largest reading of each message", frame=START),
    Given(
        "logs/tf_static_zero_quat_first",
        "fixposition_driver#69, OrbbecSDK_ROS1#49, realsense-ros PR 759",
        "the transform of 'FP_ENU0' .* is no rotation",
        frame=START,
    ),
    Given("logs/sim_reset", "geometry2#43, geometry2#329, slam_gmapping#66", "clock .* begins again", frame=START),
    Given(
        "logs/odom_of_camera", "realsense-ros#1526, realsense-ros#912, realsense-ros#2411", frame=(1.6, 1.2, math.pi)
    ),
    Given("logs/two_parents", "autoware_universe#6676, hector_slam#27, zed-ros-wrapper#447", "2 parents", frame=START),
    Given("logs/tf_static_other_parent_later", "depthai-ros#619, geometry2#705", frame=START),
    Given("logs/inverted_odom_tf", "kiss-icp#371, viso2#33, cob_control#259", frame=START),
    Given("logs/flaser_541_270.log", "the readers of gmapping and MRPT; carmen_publisher#1", "270°", frame=START),
    Given("logs/flaser_682_hokuyo.log", "the readers of gmapping and MRPT", r"239\.4°", frame=START),
    Given(
        "logs/time_increment_4x",
        "turtlebot3#690, webots_ros2#1047, rviz#318",
        "the time_increment is not used",
        frame=START,
    ),
    Given("logs/noreturn_is_range_max", "laser_geometry#9, cob_robots#732", "are exactly range_max, 4 m"),
    Given("logs/log_corridor_inf.csv", "none: walls at 9.62 m of a range_max of 10", "0 findings", command=("doctor",)),
    Given("logs/log_open20_all_inf.csv", "slam_toolbox#662, slam_gmapping#47", "--no-return free"),
    Given("logs/range_max_zero", "rplidar_ros#71, rplidar_ros#115", "range_max of 0 m", frame=START),
    Given("logs/range_limits_swapped", "none: limits the other way round", "the other way round", frame=START),
    Given("logs/range_fixed_distance", "REP 117", "a ranger for one fixed distance"),
    Given("logs/odom_zero_quat", "rbcar_sim#4", "its quaternion is 0, 0, 0, 0"),
    Given("logs/posestamped_only", "evo#660", frame=START),
    Given("logs/mcap_empty_schema.mcap", "rosbag2#1922", frame=START),
    Given("logs/foxglove_json.mcap", "mcap#316, rerun#9949", "in json on /scan are read", frame=START),
    Given("logs/livox_custom.bag", "livox_ros_driver#104", "5 scans of 360 beams"),
    Given("logs/bag_2010_index_length.bag", "scan_tools PR 77", "60 scans", "damage", frame=START),
    Given("logs/bag_rosrecord_v12.bag", "wiki.ros.org/Bags/Format/1.2", r"#ROSRECORD V1\.2.*rosbag filter"),
    Given("logs/split_nometa", "rosbag2#1619, rosbag2#990", "2 files are read as one recording", frame=START),
    Given("logs/rawlaser1.log", "none: CARMEN's own lines", "RAWLASER1 lines do not say where", frame=START),
    Given("logs/no_poses", "evo#393", "holds no poses"),
    Given(
        "logs/no_poses",
        "evo#393",
        unsaid="no poses",
        options=("--tum-trajectory", "logs/tum_ok.txt"),
        frame=START,
    ),
    Given("logs/log_utm.csv", "gps_amcl#5, marti_common#561", "less 691000 m in x and 5334000 m in y"),
    *(
        Given(f"maps/{name}", source, said, command=("info",))
        for name, source, said in (
            ("absolute.yaml", "navigation#1004", "'room.pgm' beside the yaml is read"),
            ("absdir/a.yaml", "navigation#31, turtlebot3#267", "'a.pgm' beside the yaml is read"),
            ("mode_cap.yaml", "nav2_map_server", "20 × 10 cells"),
            ("la.yaml", "stdr_simulator#161", "the image has an alpha channel"),
        )
    ),
    *(
        Given(f"nav2/{name}.yaml", source, said, command=ROOM)
        for name, source, said in (
            (
                "nav2_noplugins",
                "costmap_2d_ros.cpp",
                "static_layer, obstacle_layer, inflation_layer\n(.*\n)*  243 lethal",
            ),
            ("nav2_trackoff", "navigation#261, navigation#223", "count as free: track_unknown_space is off"),
            ("nav2_dump_fqn", "ros2 param dump", "243 lethal"),
            ("nav2_obs_sources", "nav2_costmap_2d", "243 lethal"),
            ("nav2_default_types", "nav2_costmap_2d", "243 lethal"),
            ("nav2_foxy_local", "nav2_costmap_2d of Foxy", "local_costmap: voxel_layer, inflation_layer"),
            ("nav2_denoise", "nav2_costmap_2d", "static_layer, denoise, inflation_layer\n(.*\n)*  243 lethal"),
            ("nav2_small_infl", "navigation2#4271, navigation2 PR 5148", "smaller than the inscribed radius"),
        )
    ),
    *(
        Given(f"clouds/{name}", source, said, command=("info",))
        for name, source, said in (
            ("space_decimal_comma.xyz", "umap#159, QGIS#52741", CLOUD),
            ("semi_decimal_comma.csv", "umap#159, QGIS#52741", CLOUD),
            ("las_degrees.las", "Helios#71, entwine#305", "metres east and north of 11.5"),
            ("utm.xyz", "none: georeferenced", "its origin at 691,000, 5,334,000, 500 m"),
            ("las12_pf1.las", "none: georeferenced", "its origin at 691,000, 5,334,000, 500 m"),
            ("camera_first.ply", "plyfile, Open3D", CLOUD),
            ("vertex_list.ply", "plyfile, Open3D", CLOUD),
            ("count0.pcd", "PDAL#3254", CLOUD),
            ("lowertype.pcd", "Open3D#6924", CLOUD),
            ("upper_xyz.pcd", "Open3D#6924", CLOUD),
            ("comment_first.pcd", "PDAL#3254", CLOUD),
            ("wh_mismatch.pcd", "PDAL#3254", CLOUD + r"(.*\n)*.*42 × 1; the former is taken"),
            ("bom.csv", "none: a byte-order mark", CLOUD),
            ("easting.csv", "none: names of columns", CLOUD + r"(.*\n)*.*Easting, Northing, Elevation are x, y, z"),
            ("ouster.csv", "none: names of columns", CLOUD + r"(.*\n)*.*converted to metres"),
            ("pts_two_scans.pts", "Open3D#913", CLOUD + r"(.*\n)*.*holds 2 scans"),
            ("color.ot", "octomap#67, octomap#272", "30 voxels occupied"),
            ("las_truncated.las", "none: fewer points than stated", "40 points claimed, 36 there"),
        )
    ),
)


class Score(NamedTuple):
    """Of a map in per cent: occupied cells on true walls, and walls that it has."""

    on_walls: int
    found: int


def printed(reports: Path, case: Given, out: Path) -> str:
    """Return what the command prints on an input; a map is written to ``out``, a prefix."""
    options = [str(reports / one) if one.startswith("logs/") else one for one in case.options]
    words = [str(reports / one) if one.startswith("maps/") else one for one in case.command]
    arguments = [*words, str(reports / case.path), *options]
    if case.command[0] in {"map", "costmap"}:
        arguments += ["--out", str(out)]
    told = CliRunner().invoke(app, arguments)
    return told.output


def score(reports: Path, case: Given, out: Path) -> Score:
    """Return what the folder's own scorer says of the map with the prefix ``out``."""
    generator = str(reports / "generator")
    sys.path.insert(0, generator)
    try:
        scorer = importlib.import_module("score")
    finally:
        sys.path.remove(generator)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # it leaves a file open
        said = scorer.score(str(out.with_suffix(".yaml")), case.frame)
    on_walls, found = (int(number) for number in re.findall(r"(\d+)% o", said))
    return Score(on_walls, found)
