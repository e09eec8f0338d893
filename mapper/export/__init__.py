"""What one takes away besides the map's own files: a log and its map for other viewers, and the robot's way."""

from mapper.export.growing_map import GrowingMap
from mapper.export.recording import write_mcap
from mapper.export.trajectory import tum_lines, tum_text

__all__ = ["GrowingMap", "tum_lines", "tum_text", "write_mcap"]
