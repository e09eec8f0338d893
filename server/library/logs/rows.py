"""The records of logs as rows of a table."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Collection, Sequence
from dataclasses import asdict
from typing import Any

from sqlalchemy import Connection, Row, delete, insert, select, update

from server.jobs.record import Failure
from server.library.logs.records import Record, summary_from_json
from server.library.store.database import Database
from server.library.store.tables import logs


class LogRows:
    """:class:`server.library.logs.records.Records` in a database."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def load(self) -> asyncio.Future[Sequence[Record]]:
        """Return every record, oldest first."""
        return self._database.run(_load)

    def put(self, record: Record) -> asyncio.Future[None]:
        """Store ``record``, replacing any older one with its id."""
        return self._database.run(lambda connection: upsert_log(connection, record))

    def mark_used(self, record: Record) -> asyncio.Future[None]:
        """Store the time at which a log was used, and nothing else of its record."""
        return self._database.run(
            lambda connection: _ignore(
                connection.execute(update(logs).where(logs.c.id == record.id).values(used_s=record.used_s))
            )
        )

    def get(self, record_ids: Collection[str]) -> asyncio.Future[Sequence[Record]]:
        """Return the existing records with these ids."""
        query = select(logs).where(logs.c.id.in_(record_ids))
        return self._database.run(lambda connection: [_record(row) for row in connection.execute(query)])

    def change(self, record: Record) -> asyncio.Future[None]:
        """Run :meth:`writing` in a transaction."""
        return self._database.run(self.writing(record))

    def writing(self, record: Record) -> Callable[[Connection], None]:
        """Return a function that writes the row of a record in a transaction, unless it is that of a deleted upload."""
        return lambda connection: (_change_log if record.source == "upload" else upsert_log)(connection, record)

    def is_stored(self, sha256: str) -> asyncio.Future[bool]:
        """Return whether any record has these bytes."""
        query = select(logs.c.id).where(logs.c.sha256 == sha256).limit(1)
        return self._database.run(lambda connection: connection.execute(query).first() is not None)

    def delete(self, record_id: str) -> asyncio.Future[None]:
        """Delete a record. A missing one is no error."""

        def work(connection: Connection) -> None:
            connection.execute(delete(logs).where(logs.c.id == record_id))

        return self._database.run_deletion(work)


def _ignore(_: object) -> None:
    """Return None, because the result of a statement is of no use after its transaction."""


def _change_log(connection: Connection, record: Record) -> None:
    """Write the row of a record, unless it was deleted."""
    connection.execute(update(logs).where(logs.c.id == record.id).values(_values(record)))


def upsert_log(connection: Connection, record: Record) -> None:
    """Write the row of a record, replacing any older one with its id."""
    values = _values(record)
    if connection.execute(update(logs).where(logs.c.id == record.id).values(values)).rowcount == 0:
        connection.execute(insert(logs).values(values))


def ensure_log(connection: Connection, record: Record) -> None:
    """Write the row of a record if it is missing, as for the sample and for unread logs of the folder."""
    if connection.execute(select(logs.c.id).where(logs.c.id == record.id)).first() is None:
        upsert_log(connection, record)


def _load(connection: Connection) -> Sequence[Record]:
    return [_record(row) for row in connection.execute(select(logs).order_by(logs.c.created_s))]


def _values(record: Record) -> dict[str, Any]:
    return {
        "id": record.id,
        "owner": record.owner,
        "name": record.name,
        "source": record.source,
        "state": record.state,
        "bytes": record.bytes,
        "sha256": record.sha256,
        "created_s": record.created_s,
        "used_s": record.used_s,
        "error_code": None if record.error is None else record.error.code,
        "error_message": None if record.error is None else plain(record.error.message),
        "attempts": record.attempts,
        "summary": None if record.summary is None else json.dumps(asdict(record.summary)),
    }


def plain(message: str) -> str:
    """Return a message that may quote a hostile file in a form that every database accepts."""
    return message.encode("utf-8", "replace").decode().replace("\0", "")


def _record(row: Row[Any]) -> Record:
    values = dict(row._mapping)  # noqa: SLF001 - SQLAlchemy's public name for it
    code, message = values.pop("error_code"), values.pop("error_message")
    error = None if code is None else Failure(code, message or "")
    values["summary"] = summary_from_json(json.loads(values["summary"] or "null"))
    return Record(**values, error=error, progress=1.0 if values["state"] == "ready" else 0.0)
