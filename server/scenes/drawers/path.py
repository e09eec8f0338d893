"""A path on the floor."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from server.scenes.drawer import Drawer, differs
from server.sessions.drawings import Path

MAX_SEGMENTS = 4000
PATH_Z = 0.03


def path_segments(poses: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return the path along ``poses`` (n, 3) as segments (m, 2, 3) on the floor, at most :data:`MAX_SEGMENTS`."""
    step = -(-len(poses) // MAX_SEGMENTS) or 1
    points = np.column_stack([poses[::step, :2], np.full(len(poses[::step]), PATH_Z)]).astype(np.float32)
    return np.stack([points[:-1], points[1:]], axis=1)


class PathDrawer(Drawer[Path, Path]):
    """Sends the whole path if it changed."""

    _shown: Path | None = None

    def show(self, content: Path) -> None:
        """Draw the path."""
        old, self._shown = self._shown, content
        if not differs(old, content, "poses", "color"):
            return
        self.scene.add_line_segments(
            f"{self.path}/line", path_segments(content.poses), content.color, thickness=1.0, thickness_units="screen"
        )
