"""Changes of a shared database by other services, or other workers of this one, applied to the data in memory.

PostgreSQL announces them (LISTEN); SQLite is polled (:mod:`server.library.store.recorded_changes`).
"""

from __future__ import annotations

import asyncio
import sqlite3
from collections.abc import Awaitable, Callable
from pathlib import Path

import structlog

from server.library.store.announcing import CHANNEL
from server.library.store.database import Database
from server.library.store.recorded_changes import RecordedChanges
from server.storage import StorageError

AGAIN_S = 1.0  #: pause before the database is tried again
LOOK_EVERY_S = 0.1  #: interval of polling SQLite

_log = structlog.get_logger(__name__)

Follow = Callable[[set[str] | None], Awaitable[None]]
"""Called with the changed keys of a table; None: any of them may have changed."""


class Changes:
    """Calls the functions of ``followers``, by table, after changes by other services. Used from the event loop.

    After each connection all tables are followed, because earlier announcements were missed.
    """

    def __init__(self, database: Database, **followers: Follow) -> None:
        self._database = database
        self._followers = followers
        self._changed: dict[str, set[str] | None] = {}
        self._wake = asyncio.Event()
        self._tasks: list[asyncio.Task[None]] = []

    def begin(self) -> None:
        """Start, if the database is shared."""
        if self._database.is_shared:
            hear = self._listen() if self._database.file is None else self._look(self._database.file)
            self._tasks = [asyncio.create_task(hear), asyncio.create_task(self._follow())]

    async def close(self) -> None:
        """Stop."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def _listen(self) -> None:
        import psycopg  # noqa: PLC0415 - only where the database is PostgreSQL

        while True:
            try:
                async with await psycopg.AsyncConnection.connect(self._database.address, autocommit=True) as connection:
                    await connection.execute(f"LISTEN {CHANNEL}")
                    self._changed = dict.fromkeys(self._followers)
                    self._wake.set()
                    async for notice in connection.notifies():
                        if notice.pid != self._database.pid:
                            self._note(*notice.payload.split(" ", 1))
            except psycopg.Error as error:
                _log.warning("changes of other services are not heard", error=str(error).partition("\n")[0])
            await asyncio.sleep(AGAIN_S)

    async def _look(self, file: Path) -> None:
        changes = RecordedChanges(file)
        try:
            while True:
                try:
                    new = await asyncio.to_thread(changes.new)
                except sqlite3.Error as error:
                    _log.warning("changes of other workers are not seen", error=str(error))
                    await asyncio.sleep(AGAIN_S)
                    continue
                if new is None:
                    self._changed = dict.fromkeys(self._followers)
                    self._wake.set()
                for table, key in new or ():
                    self._note(table, key)
                await asyncio.sleep(LOOK_EVERY_S)
        finally:
            changes.close()

    def _note(self, table: str, key: str) -> None:
        known = self._changed.setdefault(table, set())
        if known is not None:
            known.add(key)
        self._wake.set()

    async def _follow(self) -> None:
        while True:
            await self._wake.wait()
            self._wake.clear()
            changed, self._changed = self._changed, {}
            for table, follow in self._followers.items():  # in their order: a log before its additions
                if table in changed:
                    try:
                        await follow(changed[table])
                    except StorageError:
                        _log.warning("changes of other services could not be read", table=table)
                        await asyncio.sleep(AGAIN_S)
                        self._changed[table] = None
                        self._wake.set()
