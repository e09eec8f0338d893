"""The records of logs as rows of a table."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from sqlalchemy import Connection, Row, delete, insert, select, update

from server.library.database import Database
from server.library.records import Failure, Record, summary_from_json
from server.library.tables import logs


class LogRows:
    """:class:`server.library.records.Records` in a database."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def load(self) -> asyncio.Future[Sequence[Record]]:
        """Return every record, oldest first."""
        return self._database.run(_load)

    def put(self, record: Record) -> asyncio.Future[None]:
        """Keep ``record`` in the place of any older one with its id."""
        return self._database.run(lambda connection: upsert_log(connection, record))

    def delete(self, record_id: str) -> asyncio.Future[None]:
        """Forget a record; one that is not there is no error."""

        def work(connection: Connection) -> None:
            connection.execute(delete(logs).where(logs.c.id == record_id))

        return self._database.run(work)


def upsert_log(connection: Connection, record: Record) -> None:
    """Write the row of a record, in the place of any older one with its id."""
    values = _values(record)
    if connection.execute(update(logs).where(logs.c.id == record.id).values(values)).rowcount == 0:
        connection.execute(insert(logs).values(values))


def ensure_log(connection: Connection, record: Record) -> None:
    """Write the row of a record unless it is there: of the sample, and of unread logs of the folder, there is none."""
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
        "error_message": None if record.error is None else _plain(record.error.message),
        "attempts": record.attempts,
        "summary": None if record.summary is None else json.dumps(asdict(record.summary)),
    }


def _plain(message: str) -> str:
    """Return a message that may quote a hostile file as every database takes it."""
    return message.encode("utf-8", "replace").decode().replace("\0", "")


def _record(row: Row[Any]) -> Record:
    values = dict(row._mapping)  # noqa: SLF001 - SQLAlchemy's public name for it
    code, message = values.pop("error_code"), values.pop("error_message")
    error = None if code is None else Failure(code, message or "")
    values["summary"] = None if values["summary"] is None else summary_from_json(json.loads(values["summary"]))
    return Record(**values, error=error, progress=1.0 if values["state"] == "ready" else 0.0)
