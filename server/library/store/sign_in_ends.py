"""The sign-ins that ended early, for all services that share a database.

A service with its own database keeps them only in a file of its data folder.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

from sqlalchemy import Connection, delete, insert, select

from server.library.store.database import Database
from server.library.store.tables import ended_sign_ins

KEPT_S = 31 * 24 * 3600.0  #: longer than the validity of any cookie


class SignInEnds:
    """Ended sign-ins by name, with their creation times. ``take_over`` is called with those of all services.

    Used from the event loop. All methods raise :class:`StorageError`.
    """

    def __init__(self, database: Database) -> None:
        self._database = database
        self.take_over: Callable[[Mapping[str, int]], None] = lambda _: None

    async def follow(self, _: object = None) -> None:
        """Read the ended sign-ins."""
        if self._database.is_shared:
            self.take_over(await self._database.run(_load))

    async def put(self, ended: Mapping[str, int]) -> None:
        """Publish ended sign-ins to all services, including already known ones."""
        if self._database.is_shared:
            await self._database.run(lambda connection: _put(connection, ended))


def _load(connection: Connection) -> Mapping[str, int]:
    return {row.name: row.given_s for row in connection.execute(select(ended_sign_ins))}


def _put(connection: Connection, ended: Mapping[str, int]) -> None:
    known = _load(connection)
    rows = [{"name": name, "given_s": at} for name, at in ended.items() if at > known.get(name, 0)]
    if rows:
        connection.execute(delete(ended_sign_ins).where(ended_sign_ins.c.name.in_([row["name"] for row in rows])))
        connection.execute(insert(ended_sign_ins), rows)
    connection.execute(delete(ended_sign_ins).where(ended_sign_ins.c.given_s < time.time() - KEPT_S))
