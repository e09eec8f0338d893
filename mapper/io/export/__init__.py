"""Exports other than map files: a log with its map for other viewers, and the robot's trajectory."""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import imported_later
from mapper.io.export.trajectory import tum_lines, tum_text

if TYPE_CHECKING:
    from mapper.io.export.growing_map import GrowingMap
    from mapper.io.export.recording import write_mcap

__all__ = ["GrowingMap", "tum_lines", "tum_text", "write_mcap"]

# The MCAP library and the mapping kernels are imported on the first export.
__getattr__ = imported_later(__name__, __file__)
