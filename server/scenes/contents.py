"""The drawers of one scene: one for each current drawing of the model."""

from __future__ import annotations

import math
import time
from typing import Any

import structlog
import viser

from server.scenes.drawer import Drawer, DrawerContext
from server.scenes.drawers import Drawers
from server.scenes.panel import VisibilitySwitches
from server.scenes.reading import Reading, SceneState
from server.scenes.viser_server import ViserServer
from server.sessions.drawings import MAX_DRAWING_BYTES, Drawing, Point

SHARE = 0.1  #: largest share of the time for one drawing,
QUICK_S = 0.01  #: unless it takes less than this, because on a busy machine even a pose may take milliseconds

_log = structlog.get_logger(__name__)


class SceneContents:
    """Shows the drawings of each state. :meth:`show` is called from threads, one call at a time."""

    def __init__(
        self,
        server: ViserServer,
        drawers: Drawers,
        context: DrawerContext,
        switches: VisibilitySwitches,
        session: str,
    ) -> None:
        self._server = server
        self._types = drawers
        self._context = context
        self._switches = switches
        self._session = session  #: for the log
        self._drawers: dict[str, Drawer[Any, Any]] = {}
        self._due: dict[str, float] = {}  #: when each drawing may be drawn again
        self._refused: set[str] = set()
        self.height = 1.0  #: of the map's columns, as a multiple of the default

    def due(self, drawing: Drawing) -> bool:
        """Return whether a drawing may be drawn now."""
        return self._due.get(drawing.name, 0.0) <= time.monotonic()

    def set_height(self, height: float) -> None:
        """Draw the map's columns ``height`` times as high as by default (called on a thread)."""
        self.height = height
        with self._server.atomic():
            for drawer in list(self._drawers.values()):
                drawer.set_height(height)

    def met(self, origin: Point, direction: Point) -> Point | None:
        """Return where a line of sight first meets the columns of a map (any thread); None if it does not."""
        shown = [drawer for drawer in list(self._drawers.values()) if drawer.frame.visible]
        places = [place for drawer in shown if (place := drawer.met(origin, direction)) is not None]
        return min(places, key=lambda place: math.dist(origin, place), default=None)

    def draw_all_now(self) -> None:
        """Make every drawing due."""
        self._due.clear()

    @property
    def unsettled(self) -> bool:
        """Whether a change by a user in the scene still waits for confirmation by the model."""
        return any(drawer.unsettled for drawer in self._drawers.values())

    def show(self, state: SceneState) -> float | None:
        """Draw what changed. Return the seconds until the next unread drawing is due, None if all were read."""
        readings = [reading for reading in state.readings if self._is_allowed(reading.drawing)]
        present = {reading.drawing.name: self._types[type(reading.drawing)] for reading in readings}
        gone = [name for name, drawer in self._drawers.items() if present.get(name) is not type(drawer)]
        for name in gone:
            self._drawers.pop(name).remove()
            self._due.pop(name, None)
        known = len(self._drawers)
        for reading in readings:
            if reading.content is not None:
                self._show_one(reading)
        if gone or len(self._drawers) > known:
            self._switches.set_nodes(self._nodes())
        late = [self._due.get(reading.drawing.name, 0.0) for reading in readings if reading.content is None]
        return max(min(late) - time.monotonic(), 0.0) if late else None

    def _show_one(self, reading: Reading) -> None:
        drawing, started, queued = reading.drawing, time.monotonic(), self._server.queued
        with self._server.atomic():
            drawer = self._drawers.get(drawing.name)
            if drawer is None:
                drawer = self._types[type(drawing)](self._context, drawing)
                drawer.set_height(self.height)
                self._drawers[drawing.name] = drawer
            drawer.show(reading.content)
        took = reading.seconds + time.monotonic() - started
        if took < QUICK_S:
            took = 0.0
        was_sent = self._server.queued > queued
        pause = 1.0 / drawer.max_hz if was_sent or drawer.reads_live_arrays else 0.0
        self._due[drawing.name] = started + max(pause, took / SHARE)

    def _is_allowed(self, drawing: Drawing) -> bool:
        """Return whether a drawing is small enough to be sent. If it is not, that is logged once."""
        if drawing.nbytes <= MAX_DRAWING_BYTES:
            self._refused.discard(drawing.name)
            return True
        if drawing.name not in self._refused:
            self._refused.add(drawing.name)
            _log.warning(
                "drawing too large for the 3D view",
                session=self._session,
                drawing=drawing.name,
                bytes=drawing.nbytes,
                limit=MAX_DRAWING_BYTES,
            )
        return False

    def _nodes(self) -> list[tuple[str, viser.SceneNodeHandle]]:
        return [(label, node) for drawer in self._drawers.values() for label, node in drawer.labels.items() if label]
