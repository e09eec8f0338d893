"""Simultaneous localization and mapping of lidar logs: front end, loop closure, pose graph, joint refinement."""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import imported_later

if TYPE_CHECKING:
    from mapper.sensors.pose_graph import LOOP, ODOMETRY, PoseGraph
    from mapper.slam.config import SLAM_PARAMETERS, SlamConfig
    from mapper.slam.estimate import SlamEstimate
    from mapper.slam.merge import MergeCancelled, MergedLogs, MergeProgress, map_along, merge_logs, merged_graph
    from mapper.slam.merged_log import MERGED
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
    "map_along",
    "merge_logs",
    "merged_graph",
    "slam_log",
]

__getattr__ = imported_later(__name__, __file__)
