"""Straight lines."""

from __future__ import annotations

from server.scenes.drawer import Drawer, same_array
from server.sessions.drawings import Segments


class SegmentsDrawer(Drawer[Segments, Segments]):
    """Sends ends and colours in one message if they changed, otherwise only a changed pose."""

    _shown: Segments | None = None

    def show(self, content: Segments) -> None:
        """Draw the lines."""
        self.place(content)
        old, self._shown = self._shown, content
        if (
            old is not None
            and (old.width, old.unit) == (content.width, content.unit)
            and same_array(old.points, content.points)
            and same_array(old.colors, content.colors)
        ):
            return
        self.scene.add_line_segments(
            f"{self.path}/lines",
            content.points,
            content.colors,
            thickness=content.width,
            thickness_units=content.unit,
        )
