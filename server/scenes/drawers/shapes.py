"""Shapes that viser draws with one message: points, straight lines, a path, a triangle mesh, an image."""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from server.scenes.drawer import Drawer, DrawerContext, differs
from server.sessions.drawings import Image, Mesh, Path, Points, Segments


class PointsDrawer(Drawer[Points, Points]):
    """Sends points and colours in one message if they changed, otherwise only a changed pose or clip box.

    viser clips nothing. ``static/src/pages/scene.ts`` reads the corners of the clip box from the positions of two nodes
    next to the cloud, and makes viser's client draw the points in between.
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
            precision="float32",  # viser's own float16 has an error of 3 cm at 50 m
        )


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


class MeshDrawer(Drawer[Mesh, Mesh]):
    """Sends vertices and faces in one message if they changed, otherwise only a changed pose."""

    _shown: Mesh | None = None
    _node: viser.MeshHandle | None = None

    def show(self, content: Mesh) -> None:
        """Draw the mesh."""
        self.place(content)
        old, self._shown = self._shown, content
        if not differs(old, content, "vertices", "faces", "color", "opacity", "flat_shading", "two_sided"):
            return
        if len(content.faces):
            # The node is created again, because its vertices and faces must arrive together.
            self._node = self.scene.add_mesh_simple(
                f"{self.path}/mesh",
                content.vertices,
                content.faces,
                color=content.color,
                opacity=content.opacity,
                flat_shading=content.flat_shading,
                side="double" if content.two_sided else "front",
                cast_shadow=False,
            )
        elif self._node is not None:
            self._node.remove()
            self._node = None


class ImageDrawer(Drawer[Image, Image]):
    """Sends the pixels as PNG if they changed, otherwise only a changed pose."""

    _shown: Image | None = None
    _node: viser.ImageHandle | None = None

    def show(self, content: Image) -> None:
        """Draw the image."""
        self.place(content)
        old, self._shown = self._shown, content
        if self._node is None or differs(old, content, "width", "height"):
            self._node = self.scene.add_image(
                f"{self.path}/image",
                content.pixels,
                content.width,
                content.height,
                format="png",
                cast_shadow=False,
                # Half a turn about x, because viser's images have their first row at the smallest y of their own frame.
                wxyz=(0.0, 1.0, 0.0, 0.0),
            )
        elif differs(old, content, "pixels"):
            self._node.image = content.pixels
