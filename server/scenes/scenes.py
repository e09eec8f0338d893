"""All scenes of the service: one per session, created when a browser first opens it, closed when idle."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING

import structlog

from server.logging import short_hash

if TYPE_CHECKING:
    from server.scenes.drawers import Drawers
    from server.scenes.scene import Scene
    from server.sessions import SessionHost

IDLE_S = 60.0  #: a scene without a browser is closed after this time, seconds
CHECK_S = 15.0

_log = structlog.get_logger(__name__)


def _scene_class() -> type[Scene]:
    from server.scenes.scene import Scene  # noqa: PLC0415 - viser takes 0.3 s to import: not at start-up

    return Scene


async def _open(session: SessionHost, drawers: Drawers | None) -> Scene:
    scene_class = await asyncio.to_thread(_scene_class)
    return await (scene_class.open(session) if drawers is None else scene_class.open(session, drawers))


class Scenes:
    """The open scenes by session. Used from the event loop only. :meth:`close` ends all of them.

    ``drawers`` maps types of drawings to drawers; None for those of ``server.scenes.drawers``.
    """

    def __init__(self, *, drawers: Drawers | None = None, idle_s: float = IDLE_S, check_s: float = CHECK_S) -> None:
        self._drawers = drawers
        self._idle_s = idle_s
        self._check_s = check_s
        self._scenes: dict[str, asyncio.Task[Scene]] = {}
        self._closing: set[asyncio.Task[None]] = set()
        self._reaper: asyncio.Task[None] | None = None

    def __len__(self) -> int:
        return len(self._scenes)

    async def get(self, session: SessionHost) -> Scene:
        """Return the session's scene, creating it if needed. Concurrent callers share it."""
        task = self._scenes.get(session.id)
        if task is None:
            task = asyncio.create_task(_open(session, self._drawers))
            self._scenes[session.id] = task
            task.add_done_callback(lambda done: self._opened(session, done))
            if self._reaper is None:
                self._reaper = asyncio.create_task(self._close_idle())
        return await asyncio.shield(task)

    def _opened(self, session: SessionHost, task: asyncio.Task[Scene]) -> None:
        if task.cancelled() or task.exception() is not None:
            self._scenes.pop(session.id, None)
            return
        session.on_close.append(lambda: self.drop(session.id))
        _log.info("scene opened", session=short_hash(session.id))

    def drop(self, session_id: str) -> None:
        """Close a session's scene in the background, if it has one."""
        task = self._scenes.pop(session_id, None)
        if task is not None:
            closing = asyncio.create_task(self._close_one(session_id, task))
            self._closing.add(closing)
            closing.add_done_callback(self._closing.discard)

    async def _close_one(self, session_id: str, task: asyncio.Task[Scene]) -> None:
        await asyncio.wait([task])
        if not task.cancelled() and task.exception() is None:
            await task.result().close()
            _log.info("scene closed", session=short_hash(session_id))

    async def _close_idle(self) -> None:
        while True:
            await asyncio.sleep(self._check_s)
            now = time.monotonic()
            for session_id, task in list(self._scenes.items()):
                if task.done() and not task.result().watched and now - task.result().idle_since > self._idle_s:
                    self.drop(session_id)

    async def close(self) -> None:
        """Close every scene and wait until their threads and sockets are gone."""
        if self._reaper is not None:
            self._reaper.cancel()
            await asyncio.gather(self._reaper, return_exceptions=True)
            self._reaper = None
        for session_id in list(self._scenes):
            self.drop(session_id)
        await asyncio.gather(*self._closing, return_exceptions=True)
