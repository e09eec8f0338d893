"""The base class of drawers: a drawer shows one drawing with viser and sends only what changed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Generic, TypeVar, cast

import numpy as np
import viser

from server.sessions.drawings import Drawing, PlacedDrawing, Point, Quaternion

DrawingT = TypeVar("DrawingT", bound=Drawing)
ContentT = TypeVar("ContentT")

GizmoMoved = Callable[[str, Point, Quaternion], None]  #: name of the drawing, position and rotation


@dataclass(frozen=True, slots=True)
class DrawerContext:
    """Context of a drawer: viser's scene, and the function to call when a gizmo was moved (any thread)."""

    scene: viser.SceneApi
    gizmo_moved: GizmoMoved


class Drawer(ABC, Generic[DrawingT, ContentT]):
    """Draws successive drawings of one name with viser.

    :meth:`read` returns the content of a drawing and :meth:`show` draws it, sending what differs from the previous
    content. All calls come from threads, one at a time. A drawer puts its nodes under ``frame``, whose name is that of
    the drawing.
    """

    reads_live_arrays: ClassVar[bool] = False
    """Whether drawings contain arrays that the session updates.

    :meth:`read` is then called with the session's lock held, and must copy."""
    max_hz: ClassVar[float] = 15.0
    """Highest rate at which the drawing is read and shown; lower if that would take more than a tenth of the time."""

    def __init__(self, context: DrawerContext, drawing: DrawingT) -> None:
        self.context = context
        self.scene = context.scene
        self.path = f"/{drawing.name}"
        self.frame = context.scene.add_frame(self.path, show_axes=False)
        self.labels: dict[str, viser.SceneNodeHandle] = {drawing.label: self.frame}
        """The nodes that each switch shows and hides."""

    @classmethod
    def read(cls, drawing: DrawingT) -> ContentT:
        """Return the content to draw."""
        return cast("ContentT", drawing)

    @abstractmethod
    def show(self, content: ContentT) -> None:
        """Draw ``content``: send what differs from the previous one."""

    @property
    def unsettled(self) -> bool:
        """Whether a change by a user in the scene still waits for confirmation by the model."""
        return False

    def set_height(self, height: float) -> None:
        """Scale the height of everything on the floor by ``height``."""

    def met(self, origin: Point, direction: Point) -> Point | None:  # noqa: ARG002 - few hide what is behind them
        """Return where a line of sight meets it, metres (any thread); None if it does not, or it hides nothing."""
        return None

    def remove(self) -> None:
        """Remove everything from the scene."""
        self.frame.remove()

    def place(self, drawing: PlacedDrawing) -> None:
        """Move the frame to the drawing's pose. viser sends only changes."""
        self.frame.position = drawing.position
        self.frame.wxyz = drawing.wxyz


def yaw_wxyz(yaw: float) -> Quaternion:
    """Return the rotation by ``yaw`` radians about z as a unit quaternion."""
    return (float(np.cos(yaw / 2)), 0.0, 0.0, float(np.sin(yaw / 2)))


def differs(old: Drawing | None, new: Drawing, *names: str) -> bool:
    """Return whether two drawings differ in one of these fields; True without an old one. Arrays are compared fully."""
    return old is None or not all(_equal(getattr(old, name), getattr(new, name)) for name in names)


def _equal(a: object, b: object) -> bool:
    if a is b:
        return True
    return np.array_equal(a, b) if isinstance(a, np.ndarray) and isinstance(b, np.ndarray) else bool(a == b)
