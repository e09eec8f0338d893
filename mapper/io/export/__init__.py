"""Export besides map files: a log and its map for other viewers, and the robot's trajectory."""

from mapper.io.export.growing_map import GrowingMap
from mapper.io.export.recording import write_mcap
from mapper.io.export.trajectory import tum_lines, tum_text

__all__ = ["GrowingMap", "tum_lines", "tum_text", "write_mcap"]
