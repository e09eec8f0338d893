"""The mark of the place that a page has selected, in the 3D views of that page alone."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from server.scenes.viser_server import ViserServer
from server.sessions.drawings import CHOSEN

PATH = "/selected"
HEIGHT_M = 2.0  #: of the pole at the place: four times the highest columns of a map
WIDTH = 5.0  #: pixels

Place = tuple[float, float]  #: x, y, map metres


class Marks:
    """A pole at the selected place in each view that has one, by viser's number of its client."""

    def __init__(self, server: ViserServer) -> None:
        self._server = server
        self._shown: dict[int, Place] = {}

    def show(self, places: Mapping[int, Place]) -> None:
        """Draw what changed (a thread)."""
        for number, client in self._server.get_clients().items():
            place = places.get(number)
            if place == self._shown.get(number):
                continue
            if place is None:
                client.scene.remove_by_name(PATH)
                del self._shown[number]
                continue
            pole = np.array([[(*place, 0.0), (*place, HEIGHT_M)]], dtype=np.float32)
            client.scene.add_line_segments(PATH, pole, CHOSEN, thickness=WIDTH, thickness_units="screen")
            self._shown[number] = place

    def forget(self, number: int) -> None:
        """Note that a client has disconnected (any thread)."""
        self._shown.pop(number, None)
