"""A point cloud."""

from __future__ import annotations

from server.scenes.drawer import Drawer, DrawerContext, differs
from server.sessions.drawings import Points


class PointsDrawer(Drawer[Points, Points]):
    """Sends points and colours in one message if they changed, otherwise only a changed pose or clip box.

    viser clips nothing: ``static/src/pages/scene.ts`` takes the places of two nodes beside the cloud for the corners of
    its clip box, and has viser's client draw the points in between.
    """

    def __init__(self, context: DrawerContext, drawing: Points) -> None:
        super().__init__(context, drawing)
        self._shown: Points | None = None
        names = () if drawing.clip is None else ("clip_low", "clip_high")
        self._corners = [self.scene.add_frame(f"{self.path}/{name}", show_axes=False) for name in names]

    def show(self, content: Points) -> None:
        """Draw the points."""
        self.place(content)
        for corner, place in zip(self._corners, content.clip or (), strict=True):
            corner.position = place
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
