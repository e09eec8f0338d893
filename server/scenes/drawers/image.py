"""An image."""

from __future__ import annotations

import viser

from server.scenes.drawer import Drawer, differs
from server.sessions.drawings import Image


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
