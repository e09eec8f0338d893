"""Simultaneous localization and mapping of lidar logs: front end, loop closure, pose graph, joint refinement."""

from mapper.sensors.pose_graph import LOOP, ODOMETRY, PoseGraph
from mapper.slam.config import SLAM_PARAMETERS, SlamConfig
from mapper.slam.estimate import SlamEstimate, estimate
from mapper.slam.merge import MergeCancelled, MergedLogs, MergeProgress, map_along, merge_logs, merged_graph
from mapper.slam.merged_log import MERGED, merged_log
from mapper.slam.optimise import optimise
from mapper.slam.result import LoopCandidates, SlamCancelled, SlamProgress, SlamResult
from mapper.slam.slam import Slam
from mapper.slam.whole_log import slam_log

__all__ = [
    "LOOP",
    "MERGED",
    "ODOMETRY",
    "SLAM_PARAMETERS",
    "LoopCandidates",
    "MergeCancelled",
    "MergeProgress",
    "MergedLogs",
    "PoseGraph",
    "Slam",
    "SlamCancelled",
    "SlamConfig",
    "SlamEstimate",
    "SlamProgress",
    "SlamResult",
    "estimate",
    "map_along",
    "merge_logs",
    "merged_graph",
    "merged_log",
    "optimise",
    "slam_log",
]
