"""Readers of robot logs, one file per format; :func:`open_log` finds out which one a file needs.

Trajectory names, in the order in which a log offers them (the first is its default):

``scan``      the robot's pose as each scan line states it; in a corrected log, the corrected pose
``odom``      the odometry pose that each scan line states as well, where the two differ
``wheel``     the odometry messages (CARMEN's ODOM) at the time of each scan
``truepos``   the simulator's true pose (CARMEN's TRUEPOS) at the time of each scan
"""

from mapper.io.logs.opening import is_log, log_files, open_log

__all__ = ["is_log", "log_files", "open_log"]
