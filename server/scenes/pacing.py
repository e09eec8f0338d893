"""Pacing of a 3D view: a browser that draws slowly receives the newest state instead of every state.

viser's client accepts messages as fast as they come, and processes them frame by frame; in a hidden tab it draws no
frames. A script in its page (:data:`server.scenes.proxy.SCRIPT`) reports each processed message. While a few messages
are not reported, the proxy reads no further ones from viser, whose buffer meanwhile drops messages that newer ones
replace.
"""

from __future__ import annotations

import asyncio

MOST_AHEAD = 4  #: messages that were sent and not reported as drawn; each message of a running scene contains one state
PATIENCE_S = 5.0  #: the next message is sent after this time in any case, because a report may be lost with its message

#: The report, as packed by viser's client: ``{"type": "GridbloomDrawn"}``.
DRAWN = b"\x81\xa4type\xaeGridbloomDrawn"


class Pace:
    """Messages that were sent to one browser and that it has drawn. Used from the event loop.

    There is no wait for a browser that has never reported, such as a program without the script.
    """

    def __init__(self) -> None:
        self._reports = False
        self._ahead = 0
        self._drawn = asyncio.Event()

    def drawn(self) -> None:
        """Record a report. The first one only says that reports will follow."""
        self._ahead = max(0, self._ahead - 1) if self._reports else self._ahead
        self._reports = True
        self._drawn.set()

    async def turn(self) -> None:
        """Wait until another message may be sent, and count it."""
        while self._reports and self._ahead >= MOST_AHEAD:
            self._drawn.clear()
            try:
                async with asyncio.timeout(PATIENCE_S):
                    await self._drawn.wait()
            except TimeoutError:
                self._ahead -= 1
        self._ahead += 1
