"""The record of a job on a log, and its row in the database."""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence
from dataclasses import dataclass, fields
from typing import Any, Literal, TypeVar

from sqlalchemy import Connection, Table, delete, insert, select

from server.library.logs.records import Failure, Record
from server.library.logs.rows import ensure_log

_TEXTS = ("result", "parameters", "cut", "other_cut", "mapping")  # columns of JSON

JobState = Literal["none", "queued", "running", "done", "failed", "cancelled"]


@dataclass(frozen=True, slots=True, kw_only=True)
class JobRecord:
    """A job of ``owner`` on a log; ``topic`` names its sensor. Further fields are columns of the kind's table.

    ``attempts`` counts the runs that the end of the service interrupted; ``result`` is what the HTTP interface shows of
    a job that is done.
    """

    log_id: str
    owner: str
    topic: str | None = None
    state: JobState = "none"
    created_s: float = 0.0
    attempts: int = 0
    error: Failure | None = None
    result: dict[str, Any] | None = None

    @property
    def is_unfinished(self) -> bool:
        """Whether it is queued or running."""
        return self.state in ("queued", "running")


R = TypeVar("R", bound=JobRecord)


def load_job_records(
    connection: Connection, table: Table, kind: type[R], log_ids: Collection[str] | None = None
) -> Sequence[R]:
    """Return the rows of a table of jobs as records of a ``kind``, oldest first; those of some logs, None: all."""
    wanted = select(table).order_by(table.c.created_s)
    found = []
    for row in connection.execute(wanted if log_ids is None else wanted.where(table.c.log_id.in_(log_ids))):
        values = dict(row._mapping)  # noqa: SLF001 - SQLAlchemy's public name for it
        code, message = values.pop("error_code"), values.pop("error_message")
        error = None if code is None else Failure(code, message or "")
        texts = {name: values.pop(name) for name in _TEXTS if name in values}
        told = {name: json.loads(text) for name, text in texts.items() if text is not None}
        found.append(kind(**values, **told, error=error))
    return found


def put_job_record(connection: Connection, table: Table, log: Record, record: JobRecord) -> None:
    """Write the row of a job on ``log`` in the place of the owner's older one."""
    ensure_log(connection, log)
    of_it = (table.c.owner == record.owner, table.c.log_id == record.log_id)
    connection.execute(delete(table).where(*of_it))
    values = {one.name: getattr(record, one.name) for one in fields(record)}
    error = values.pop("error")
    values |= {"error_code": error and error.code, "error_message": error and error.message}
    values |= {name: json.dumps(values[name]) for name in _TEXTS if values.get(name) is not None}
    connection.execute(insert(table).values(values))
