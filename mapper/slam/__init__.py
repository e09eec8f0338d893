"""Simultaneous localization and mapping of lidar logs: front end, loop closure, pose graph, joint refinement."""

from mapper.sensors.pose_graph import LOOP, ODOMETRY, PoseGraph
from mapper.slam.config import SLAM_PARAMETERS, SlamConfig
from mapper.slam.estimate import SlamEstimate, estimate
from mapper.slam.optimise import optimise
from mapper.slam.result import LoopCandidates, SlamCancelled, SlamProgress, SlamResult
from mapper.slam.slam import Slam, slam_log

__all__ = [
    "LOOP",
    "ODOMETRY",
    "SLAM_PARAMETERS",
    "LoopCandidates",
    "PoseGraph",
    "Slam",
    "SlamCancelled",
    "SlamConfig",
    "SlamEstimate",
    "SlamProgress",
    "SlamResult",
    "estimate",
    "optimise",
    "slam_log",
]
