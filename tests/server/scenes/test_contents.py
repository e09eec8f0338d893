"""A drawing that has not changed may be drawn again at once; one that was sent waits as its drawer states."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
import pytest
import viser

from server.scenes import contents
from server.scenes.contents import SceneContents
from server.scenes.drawer import DrawerContext
from server.scenes.drawers import DRAWERS
from server.scenes.reading import Reading, SceneState
from server.scenes.viser_server import ViserServer
from server.sessions.drawings import Points
from server.sessions.scene_controls import SceneControls


class NoSwitches:
    """A panel without switches."""

    def set_nodes(self, nodes: Iterable[tuple[str, viser.SceneNodeHandle]]) -> None:
        """Show none."""


@pytest.fixture
def server() -> Iterator[ViserServer]:
    made = ViserServer()
    yield made
    made.stop()


def test_only_what_was_sent_delays_the_next_drawing(server: ViserServer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(contents, "QUICK_S", math.inf)  # however long drawing takes on a slow machine
    context = DrawerContext(server.scene, lambda *_: None)
    shown = SceneContents(server, DRAWERS, context, NoSwitches(), "test")  # type: ignore[arg-type]
    points = Points(name="points", label="Points", points=np.zeros((3, 3), np.float32), colors=(1, 2, 3), size=0.1)

    def wait_after(drawing: Points) -> tuple[float, int]:
        """Return until when the drawing waits after it was shown, seconds from before that, and the messages sent."""
        before, queued = time.monotonic(), server.queued
        shown.show(SceneState(before, (Reading(drawing, drawing),), SceneControls(playing=False)))
        return shown._due["points"] - before, server.queued - queued

    least = 1.0 / DRAWERS[Points].max_hz
    wait, sent = wait_after(points)
    assert sent > 0
    assert wait >= least
    _, sent = wait_after(points)
    assert sent == 0
    assert shown.due(points)
    wait, sent = wait_after(replace(points, points=np.ones((3, 3), np.float32)))
    assert sent > 0
    assert wait >= least
