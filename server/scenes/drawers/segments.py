"""Straight lines."""

from __future__ import annotations

from server.scenes.drawer import Drawer, differs
from server.sessions.drawings import Segments


class SegmentsDrawer(Drawer[Segments, Segments]):
    """Sends ends and colours in one message if they changed, otherwise only a changed pose."""

    _shown: Segments | None = None

    def show(self, content: Segments) -> None:
        """Draw the lines."""
        self.place(content)
        old, self._shown = self._shown, content
        if not differs(old, content, "points", "colors", "width", "unit"):
            return
        self.scene.add_line_segments(
            f"{self.path}/lines",
            content.points,
            content.colors,
            thickness=content.width,
            thickness_units=content.unit,
        )
