"""A robot's body with an arrow for its heading, and the beams of its newest scan, which move with it."""

from __future__ import annotations

import numpy as np

from server.scenes.drawer import Drawer, DrawerContext, yaw_wxyz
from server.scenes.shapes import arrow
from server.sessions.drawings import RobotBody

BODY = (47, 150, 130)
LASER = (71, 78, 96)
NOSE = (236, 250, 246)
BEAM = (216, 137, 198)
LASER_Z = 0.2


class RobotBodyDrawer(Drawer[RobotBody, RobotBody]):
    """Sends the pose and the beams if they changed."""

    def __init__(self, context: DrawerContext, drawing: RobotBody) -> None:
        super().__init__(context, drawing)
        scene, path, radius = self.scene, self.path, drawing.radius
        body = scene.add_frame(f"{path}/body", show_axes=False)
        scene.add_cylinder(f"{path}/body/base", radius, 0.14, color=BODY, position=(0.0, 0.0, 0.11))
        scene.add_cylinder(f"{path}/body/laser", 0.45 * radius, 0.08, color=LASER, position=(0.0, 0.0, LASER_Z))
        vertices, faces = arrow(1.5 * radius, 1.1 * radius, 0.02)
        scene.add_mesh_simple(
            f"{path}/body/heading", vertices, faces, color=NOSE, flat_shading=True, position=(0, 0, 0.245)
        )
        self._beams = scene.add_line_segments(
            f"{path}/beams", np.zeros((0, 2, 3), np.float32), BEAM, thickness=1.0, thickness_units="screen"
        )
        self.labels = {drawing.label: body, drawing.beams_label: self._beams}

    def show(self, content: RobotBody) -> None:
        """Move the robot and draw its beams."""
        x, y, yaw = content.pose
        self.frame.position = (x, y, 0.0)
        self.frame.wxyz = yaw_wxyz(yaw)
        self._beams.points = content.beams  # viser sends them only if they differ
