"""The solids of a simulated world as low walls, and the border of the world."""

from __future__ import annotations

import numpy as np

from server.scenes.drawer import Drawer
from server.scenes.shapes import Mesh, boxes, extruded
from server.sessions.drawings import Walls

SOLID = (150, 160, 178)
WALL_HEIGHT = 0.16  #: metres; lower than the columns of a map, so that they remain visible
BORDER_WIDTH = 0.06  #: metres; also how far the border goes below the floor


class WallsDrawer(Drawer[Walls, Walls]):
    """Sends all walls if the solids changed."""

    _shown: Walls | None = None

    def show(self, content: Walls) -> None:
        """Draw the walls and the border.

        The ground has no colour, because one scene serves light and dark pages, and the page's own background suits
        both.
        """
        old, self._shown = self._shown, content
        if old is None or old.solids is not content.solids:
            vertices, faces = extruded(content.solids, WALL_HEIGHT)
            self.scene.add_mesh_simple(f"{self.path}/solids", vertices, faces, color=SOLID, flat_shading=True)
        if old is None or old.bounds != content.bounds:
            mesh = border(content.bounds)
            self.scene.add_mesh_simple(f"{self.path}/border", *mesh, color=SOLID, flat_shading=True)


def border(bounds: tuple[float, float, float, float]) -> Mesh:
    """Return a frame around ``bounds`` (x0, y0, x1, y1), metres, outside of them and up to the floor."""
    x0, y0, x1, y1 = bounds
    width = BORDER_WIDTH
    sides = [
        (x0 - width, y0 - width, x1 + width, y0),
        (x0 - width, y1, x1 + width, y1 + width),
        (x0 - width, y0, x0, y1),
        (x1, y0, x1 + width, y1),
    ]
    return boxes(np.array([(*side[:2], -width) for side in sides]), np.array([(*side[2:], 0.0) for side in sides]))
