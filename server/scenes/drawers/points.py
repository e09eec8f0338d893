"""A point cloud."""

from __future__ import annotations

from server.scenes.drawer import Drawer, differs
from server.sessions.drawings import Points


class PointsDrawer(Drawer[Points, Points]):
    """Sends points and colours in one message if they changed, otherwise only a changed pose."""

    _shown: Points | None = None

    def show(self, content: Points) -> None:
        """Draw the points."""
        self.place(content)
        old, self._shown = self._shown, content
        if not differs(old, content, "points", "colors", "size"):
            return
        self.scene.add_point_cloud(
            f"{self.path}/points",
            content.points,
            content.colors,
            point_size=content.size,
            point_shape="circle",
            point_shading="flat",
            precision="float32",  # viser's own float16 is 3 cm off at 50 m
        )
