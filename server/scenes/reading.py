"""The state of a session for its scene: values that later ticks do not change."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from server.scenes.axes_and_grid import axes_and_grid
from server.scenes.cameras import DEFAULT_BOUNDS
from server.scenes.drawers import Drawers
from server.sessions import SessionHost
from server.sessions.drawings import Drawing
from server.sessions.scene_controls import SceneControls


@dataclass(frozen=True, slots=True)
class Reading:
    """The content of one drawing, and the ``seconds`` taken to read it.

    ``content`` is the result of :meth:`Drawer.read`, None if the drawing is not due yet.
    """

    drawing: Drawing
    content: Any | None
    seconds: float = 0.0


@dataclass(frozen=True, slots=True)
class SceneState:
    """The state of a session between two ticks, read at ``read_at``, seconds of :func:`time.monotonic`."""

    read_at: float
    readings: tuple[Reading, ...]
    controls: SceneControls


async def read_state(session: SessionHost, drawers: Drawers, due: Callable[[Drawing], bool]) -> SceneState:
    """Read the state of a session under its lock (event loop), including the drawings of the axes and the grid.

    Arrays that the session updates are read on a thread. Raises :class:`ValueError` if two drawings have the same name,
    :class:`KeyError` for a drawing without a drawer.
    """
    async with session.locked():
        read_at = time.monotonic()
        drawings, controls = session.model.drawings(), session.model.controls()
        drawings = [*drawings, *axes_and_grid(controls.bounds or DEFAULT_BOUNDS, controls.heights[0])]
        if len({drawing.name for drawing in drawings}) < len(drawings):
            raise ValueError(f"two drawings have one name: {sorted(drawing.name for drawing in drawings)}")
        due_drawings = [drawing for drawing in drawings if due(drawing)]
        live = [drawing for drawing in due_drawings if drawers[type(drawing)].reads_live_arrays]
        read = await asyncio.to_thread(_read, live, drawers) if live else {}
    read |= _read([drawing for drawing in due_drawings if drawing.name not in read], drawers)
    return SceneState(read_at, tuple(read.get(drawing.name, Reading(drawing, None)) for drawing in drawings), controls)


def _read(drawings: list[Drawing], drawers: Drawers) -> dict[str, Reading]:
    readings = {}
    for drawing in drawings:
        started = time.monotonic()
        content = drawers[type(drawing)].read(drawing)
        readings[drawing.name] = Reading(drawing, content, time.monotonic() - started)
    return readings
