"""A hand on the mouse: it moves at the pace of an ordinary mouse, whether or not the page keeps up.

Playwright sends a move when the page has taken the last one. Here they are sent without waiting, over a second
connection to the same Chromium.
"""

from __future__ import annotations

import json
import math
import threading
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count

from websockets.sync.client import ClientConnection, connect

MOVES_PER_S = 125
SWING_S = 0.8  # there and back


class Hand:
    """A hand on the pages of a Chromium that was started with ``--remote-debugging-port``."""

    def __init__(self, port: int) -> None:
        self._port = port

    @contextmanager
    def dragging(self, address: str, here: tuple[float, float], there: tuple[float, float]) -> Iterator[None]:
        """Swing between two places of the page with this address until the block ends; its button is down already."""
        stop = threading.Event()
        with urllib.request.urlopen(f"http://127.0.0.1:{self._port}/json/list", timeout=10) as answer:
            targets = json.load(answer)
        socket = next(one["webSocketDebuggerUrl"] for one in targets if one["url"] == address)
        with connect(socket, max_queue=None) as connection:
            swinging = threading.Thread(target=_swing, args=(connection, here, there, stop))
            swinging.start()
            try:
                yield
            finally:
                stop.set()
                swinging.join()


def _swing(
    connection: ClientConnection, here: tuple[float, float], there: tuple[float, float], stop: threading.Event
) -> None:
    for i in count():
        share = 0.5 - 0.5 * math.cos(2.0 * math.pi * i / (SWING_S * MOVES_PER_S))
        x, y = (a + share * (b - a) for a, b in zip(here, there, strict=True))
        move = {"type": "mouseMoved", "x": x, "y": y, "button": "left", "buttons": 1}
        connection.send(json.dumps({"id": i, "method": "Input.dispatchMouseEvent", "params": move}))
        if stop.wait(1.0 / MOVES_PER_S):
            return
