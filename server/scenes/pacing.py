"""Pacing of a 3D view: a browser that draws slowly is sent the newest state instead of every state.

viser's client takes messages as fast as they come, keeps them, and works them off frame by frame; in a tab that is
hidden it draws no frames. A script in its page (:data:`server.scenes.proxy.SCRIPT`) reports each message once it was
worked off. While a few messages are not reported, the proxy takes no further ones from viser, whose buffer meanwhile
drops what newer messages replace.
"""

from __future__ import annotations

import asyncio

MOST_AHEAD = 4  #: messages that were sent and not reported as drawn; each of a running scene has one state
PATIENCE_S = 5.0  #: after which the next message is sent all the same: a report may be lost with its message

#: The report, as viser's client packs ``{"type": "GridbloomDrawn"}``.
DRAWN = b"\x81\xa4type\xaeGridbloomDrawn"


class Pace:
    """Messages that one browser was sent and has drawn. Used from the event loop.

    A browser that has never reported, such as a program without the script, is not waited for.
    """

    def __init__(self) -> None:
        self._reports = False
        self._ahead = 0
        self._drawn = asyncio.Event()

    def drawn(self) -> None:
        """Take a report; the first one only says that reports will come."""
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
