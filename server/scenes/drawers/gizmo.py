"""Handles for moving and rotating a frame."""

from __future__ import annotations

import time

import numpy as np
import viser

from server.scenes.drawer import Drawer, DrawerContext
from server.scenes.panel import CONFIRM_TIMEOUT_S
from server.sessions.drawings import Gizmo, Point, Quaternion

NEAR_M = 1e-3  #: largest distance, metres, between the model's and the user's position that confirms the move
NEAR_TURN = 1e-3
#: Width of a gizmo's lines, pixels. At a constant size, the area that a pointer can grab is 4.5 times as wide.
WORLD_WIDTH, SCREEN_WIDTH = 2.5, 6.0


class GizmoDrawer(Drawer[Gizmo, Gizmo]):
    """Reports moves. Shows the model's pose, except for :data:`CONFIRM_TIMEOUT_S` after an unconfirmed move."""

    def __init__(self, context: DrawerContext, drawing: Gizmo) -> None:
        super().__init__(context, drawing)
        self._name = drawing.name
        self._moved_at: float | None = None
        self._form: tuple[object, ...] | None = None
        self._node: viser.TransformControlsHandle | None = None

    def show(self, content: Gizmo) -> None:
        """Show the handles at the model's pose."""
        form = (content.scale, content.unit, content.axes, content.moves, content.turns)
        if self._node is None or form != self._form:
            self._form = form
            self._node = self._add(content)
            return
        node, moved_at = self._node, self._moved_at
        if moved_at is not None:
            confirmed = _is_near(node, content)
            if not confirmed and time.monotonic() < moved_at + CONFIRM_TIMEOUT_S:
                return
            self._moved_at = None
            if confirmed:  # correcting the last digits would move the gizmo during the drag
                return
        node.position, node.wxyz = content.position, content.wxyz

    @property
    def unsettled(self) -> bool:
        """Whether the model has not confirmed the last move yet."""
        return self._moved_at is not None

    def _add(self, content: Gizmo) -> viser.TransformControlsHandle:
        node = self.scene.add_transform_controls(
            f"{self.path}/handles",
            content.scale,
            line_width=SCREEN_WIDTH if content.unit == "screen" else WORLD_WIDTH,
            fixed=content.unit == "screen",
            active_axes=content.axes,
            disable_axes=not content.moves,
            disable_sliders=not content.moves,
            disable_rotations=not content.turns,
            depth_test=False,
            position=content.position,
            wxyz=content.wxyz,
        )

        async def moved(event: viser.TransformControlsEvent) -> None:
            if event.phase == "start":
                return
            self._moved_at = time.monotonic()
            self.context.gizmo_moved(self._name, _point(event.target.position), _quaternion(event.target.wxyz))

        node.on_update(moved)
        return node


def _is_near(node: viser.TransformControlsHandle, content: Gizmo) -> bool:
    # A quaternion and its negative are the same rotation.
    turned = 1.0 - abs(float(np.dot(node.wxyz, content.wxyz)))
    return bool(np.linalg.norm(node.position - content.position) <= NEAR_M) and turned <= NEAR_TURN


def _point(values: np.ndarray) -> Point:
    x, y, z = (float(value) for value in values)
    return (x, y, z)


def _quaternion(values: np.ndarray) -> Quaternion:
    w, x, y, z = (float(value) for value in values)
    return (w, x, y, z)
