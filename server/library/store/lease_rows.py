"""Leases as rows of a table that several services share. Each method is one transaction."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from typing import Any

from sqlalchemy import ColumnElement, Connection, delete, insert, select, text, update
from sqlalchemy.exc import IntegrityError

from server.jobs.leases import LeaseLostError
from server.library.store.database import Database
from server.library.store.tables import leases


class LeaseRows:
    """The leases that one service holds, each valid for ``lease_s`` seconds. Used from the event loop.

    All methods raise :class:`StorageError`.
    """

    def __init__(self, database: Database, lease_s: float) -> None:
        self._database = database
        self._lease_s = lease_s
        self._holder = secrets.token_hex(10)

    async def take(self, name: str) -> bool:
        """Acquire a lease unless another service holds it; return whether it was acquired."""

        def work(connection: Connection) -> bool:
            now = _now(connection)
            values = {"holder": self._holder, "until_s": now + self._lease_s, "fraction": 0.0}
            ended = update(leases).where(leases.c.name == name, leases.c.until_s < now).values(values)
            if connection.execute(ended).rowcount:
                return True
            try:
                with connection.begin_nested():
                    connection.execute(insert(leases).values(name=name, **values))
            except IntegrityError:
                return False
            return True

        return await self._database.run_deletion(work)  # a log is deleted under a lease

    async def renew(self, name: str, fraction: float) -> bool:
        """Renew a lease, and store the completed share of its job; return False if it is no longer held."""

        def work(connection: Connection) -> bool:
            now = _now(connection)
            values = {"until_s": now + self._lease_s, "fraction": fraction}
            query = update(leases).where(self._mine(name), leases.c.until_s > now).values(values)
            return connection.execute(query).rowcount > 0

        return await self._database.run(work)

    def give_back(self, name: str) -> None:
        """Release a lease after all previously queued work. If that fails, it expires."""
        mine = self._mine(name)
        done = self._database.run_deletion(lambda connection: connection.execute(delete(leases).where(mine)).rowcount)
        done.add_done_callback(lambda task: None if task.cancelled() else task.exception() and None)

    async def finish(self, name: str, work: Callable[[Any], None]) -> None:
        """Run ``work`` and release the lease in one transaction.

        Raises :class:`LeaseLostError` if it is no longer held; then nothing has changed.
        """

        def guarded(connection: Connection) -> None:
            until = connection.execute(select(leases.c.until_s).where(self._mine(name)).with_for_update()).scalar()
            if until is None or until < _now(connection):
                raise LeaseLostError("lease.lost", "Another service may do this job now.")
            connection.execute(delete(leases).where(self._mine(name)))
            work(connection)

        await self._database.run(guarded)

    async def fraction(self, name: str) -> float | None:
        """Return the completed share of a job from the holder of its lease, None if there is no holder."""

        def work(connection: Connection) -> float | None:
            row = connection.execute(select(leases).where(leases.c.name == name)).first()
            return None if row is None or row.until_s < _now(connection) else float(row.fraction)

        return await self._database.run(work)

    def _mine(self, name: str) -> ColumnElement[bool]:
        return (leases.c.name == name) & (leases.c.holder == self._holder)


def _now(connection: Connection) -> float:
    """Return the time of the database's clock, seconds since 1970, because the clocks of several machines differ."""
    is_server = connection.dialect.name == "postgresql"
    now = "extract(epoch FROM clock_timestamp())" if is_server else "(julianday('now') - 2440587.5) * 86400.0"
    return float(connection.execute(text(f"SELECT {now}")).scalar_one())
