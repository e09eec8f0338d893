"""A triangle mesh."""

from __future__ import annotations

import viser

from server.scenes.drawer import Drawer, differs
from server.sessions.drawings import Mesh


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
