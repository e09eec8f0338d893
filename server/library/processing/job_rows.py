"""The records of jobs as rows of a table."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Collection, Sequence
from typing import TypeVar

import msgspec
from sqlalchemy import Connection, delete, insert, select

from server.jobs.record import Failure, JobKind, JobRecord
from server.library.logs.records import Record
from server.library.logs.rows import ensure_log, plain
from server.library.store.database import Database
from server.library.store.tables import jobs

Q = TypeVar("Q")
R = TypeVar("R")


class JobRowsOfLogs:
    """:class:`server.jobs.record.JobRows` in a database; ``log`` returns the record of an owner's log."""

    def __init__(self, database: Database, log: Callable[[str, str], Record]) -> None:
        self._database, self._log = database, log

    def load(
        self, kind: JobKind[Q, R], log_ids: Collection[str] | None = None
    ) -> asyncio.Future[Sequence[JobRecord[Q, R]]]:
        """Return the records of a kind, oldest first; those of some logs, None: all."""
        query = select(jobs).where(jobs.c.kind == kind.name).order_by(jobs.c.created_s)
        if log_ids is not None:
            query = query.where(jobs.c.log_id.in_(log_ids))

        def work(connection: Connection) -> Sequence[JobRecord[Q, R]]:
            return [
                JobRecord(
                    log_id=row.log_id,
                    owner=row.owner,
                    request=msgspec.json.decode(row.request, type=kind.request),
                    state=row.state,
                    created_s=row.created_s,
                    attempts=row.attempts,
                    error=None if row.error_code is None else Failure(row.error_code, row.error_message or ""),
                    result=None if row.result is None else msgspec.json.decode(row.result, type=kind.result),
                )
                for row in connection.execute(query)
            ]

        return self._database.run(work)

    def put(self, kind: JobKind[Q, R], records: Sequence[JobRecord[Q, R]]) -> asyncio.Future[None]:
        """Store records, replacing the owners' older ones, in one transaction."""
        writes = [self.writing(kind, record) for record in records]

        def work(connection: Connection) -> None:
            for write in writes:
                write(connection)

        return self._database.run(work)

    def writing(self, kind: JobKind[Q, R], record: JobRecord[Q, R]) -> Callable[[Connection], None]:
        """Return a function that writes the row of a job. Raises like the library for a deleted log."""
        log, error = self._log(record.owner, record.log_id), record.error
        key = {"kind": kind.name, "owner": record.owner, "log_id": record.log_id}

        def write(connection: Connection) -> None:
            ensure_log(connection, log)
            connection.execute(delete(jobs).filter_by(**key))
            connection.execute(
                insert(jobs).values(
                    **key,
                    state=record.state,
                    created_s=record.created_s,
                    attempts=record.attempts,
                    error_code=None if error is None else error.code,
                    error_message=None if error is None else plain(error.message),
                    request=msgspec.json.encode(record.request).decode(),
                    result=None if record.result is None else msgspec.json.encode(record.result).decode(),
                )
            )

        return write
