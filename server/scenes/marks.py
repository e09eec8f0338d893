"""Drawings of a page only in its own 3D views: the selected place and the measurement."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import viser

from server.scenes.viser_server import ViserServer
from server.sessions.drawings import CHOSEN
from server.stream.commands import MeasureCommand

SELECTED, MEASURED = "/selected", "/measured"
HEIGHT_M = 2.0  #: of the pole at the place: four times the highest columns of a map
WIDTH = 5.0  #: pixels
RULER_WIDTH = 3.0  #: pixels
RULER = (110, 40, 200)
LIFT_M = 0.02  #: above the floor, so that the floor does not hide the measurement

Place = tuple[float, float]  #: x, y, map metres


class Mark(NamedTuple):
    """The marks that a view shows only for its page; None for none."""

    selected: Place | None
    measured: MeasureCommand | None


class Marks:
    """A pole at the selected place, and measured lines with their lengths, in each view that has them."""

    def __init__(self, server: ViserServer) -> None:
        self._server = server
        self._shown: dict[int, Mark] = {}  #: by the number of viser's client

    def show(self, marks: Mapping[int, Mark]) -> None:
        """Draw what changed (called on a thread)."""
        nothing = Mark(None, None)
        for number, client in self._server.get_clients().items():
            new, old = marks.get(number, nothing), self._shown.get(number, nothing)
            self._shown[number] = new
            if new.selected != old.selected:
                client.scene.remove_by_name(SELECTED)
                if new.selected is not None:
                    _draw_pole(client.scene, new.selected)
            if new.measured != old.measured:
                client.scene.remove_by_name(MEASURED)
                if new.measured is not None:
                    _draw_ruler(client.scene, new.measured)

    def forget(self, number: int) -> None:
        """Record that a client has disconnected (any thread)."""
        self._shown.pop(number, None)


def _draw_pole(scene: viser.SceneApi, place: Place) -> None:
    pole = np.array([[(*place, 0.0), (*place, HEIGHT_M)]], dtype=np.float32)
    scene.add_line_segments(SELECTED, pole, CHOSEN, thickness=WIDTH, thickness_units="screen")


def _draw_ruler(scene: viser.SceneApi, measured: MeasureCommand) -> None:
    """Draw the lines from each point to the next with their lengths, and a vertical line at the first point."""
    points = [(x, y, z + LIFT_M) for x, y, z in measured.points or ()]
    if not points:
        return
    scene.add_frame(MEASURED, show_axes=False)
    sides = list(_sides(points, closed=measured.closed))
    longest = max((math.dist(*side) for side in sides), default=1.0)
    (x, y, z), stroke = points[0], 0.05 * longest
    lines = np.array([*sides, ((x, y, z - stroke), (x, y, z + stroke))], dtype=np.float32)
    scene.add_line_segments(f"{MEASURED}/lines", lines, RULER, thickness=RULER_WIDTH, thickness_units="screen")
    for number, (a, b) in enumerate(sides):
        text, middle = f"{math.dist(a, b):.2f} m", (np.array(a) + b) / 2
        scene.add_label(f"{MEASURED}/{number}", text, position=middle, anchor="bottom-center")


def _sides(
    points: list[tuple[float, float, float]], *, closed: bool
) -> Iterator[tuple[tuple[float, float, float], tuple[float, float, float]]]:
    yield from pairwise(points)
    if closed and len(points) > 2:
        yield points[-1], points[0]
