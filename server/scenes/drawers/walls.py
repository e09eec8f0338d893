"""The solids of a simulated world as low walls, and its ground."""

from __future__ import annotations

import numpy as np

from server.scenes.drawer import Drawer
from server.scenes.shapes import boxes, extruded
from server.sessions.drawings import Walls

SOLID = (150, 160, 178)
GROUND = (228, 224, 212)
WALL_HEIGHT = 0.16  #: metres; lower than the columns of a map, so that these stay visible
GROUND_DEPTH = 0.1


class WallsDrawer(Drawer[Walls, Walls]):
    """Sends all walls if the solids changed."""

    _shown: Walls | None = None

    def show(self, content: Walls) -> None:
        """Draw the walls and the ground."""
        old, self._shown = self._shown, content
        if old is None or old.solids is not content.solids:
            vertices, faces = extruded(content.solids, WALL_HEIGHT)
            self.scene.add_mesh_simple(f"{self.path}/solids", vertices, faces, color=SOLID, flat_shading=True)
        if old is None or old.bounds != content.bounds:
            x0, y0, x1, y1 = content.bounds
            slab = boxes(np.array([[x0, y0, -GROUND_DEPTH]]), np.array([[x1, y1, 0.0]]))
            self.scene.add_mesh_simple(f"{self.path}/ground", *slab, color=GROUND, flat_shading=True)
