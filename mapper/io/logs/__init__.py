"""Readers of robot logs; :func:`open_log` selects the one for a file.

Trajectory names, in the order of a log's trajectories (the first is the default):

``scan``      the robot's pose as each scan line states it; in a corrected log, the corrected pose
``odom``      the odometry pose that each scan line states as well, where the two differ
``wheel``     the odometry messages (CARMEN's ODOM) at the time of each scan
``truepos``   the simulator's true pose (CARMEN's TRUEPOS) at the time of each scan
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import imported_later

if TYPE_CHECKING:
    from mapper.io.logs.opening import is_log, log_files, odometry_records, open_log, open_robot_log

__all__ = ["is_log", "log_files", "odometry_records", "open_log", "open_robot_log"]

# The readers of all formats are imported on first use, because importers of only `mapper.io.logs.summary`, such as the
# service, do not need them.
__getattr__ = imported_later(__name__, __file__)
