"""The record of a job that merges two logs, and its row in the database."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from sqlalchemy import Connection, delete, insert, select

from server.library.log_rows import ensure_log
from server.library.pose_job_record import JobState
from server.library.records import Failure, Record
from server.library.tables import merge_jobs


@dataclass(frozen=True, slots=True)
class MergeRecord:
    """A job of ``owner`` that merges a log with the log ``other``; ``topic`` and ``other_topic`` name their sensors.

    ``attempts`` counts the runs that the end of the service interrupted; ``result`` is what the HTTP interface shows of
    a job that is done.
    """

    log_id: str
    owner: str
    topic: str | None
    other: str
    other_topic: str | None
    state: JobState
    created_s: float
    attempts: int = 0
    error: Failure | None = None
    result: dict[str, Any] | None = None

    @property
    def is_unfinished(self) -> bool:
        """Whether it is queued or running."""
        return self.state in ("queued", "running")

    def public(self) -> dict[str, Any]:
        """Return what the HTTP interface shows."""
        return {
            "state": self.state,
            "other": self.other or None,
            "error": None if self.error is None else asdict(self.error),
            "result": self.result,
        }


def load_merge_records(connection: Connection) -> Sequence[MergeRecord]:
    """Return all rows, oldest first."""
    found = []
    for row in connection.execute(select(merge_jobs).order_by(merge_jobs.c.created_s)):
        values = dict(row._mapping)  # noqa: SLF001 - SQLAlchemy's public name for it
        code, message, result = (values.pop(name) for name in ("error_code", "error_message", "result"))
        error = None if code is None else Failure(code, message or "")
        found.append(MergeRecord(**values, error=error, result=None if result is None else json.loads(result)))
    return found


def put_merge_record(connection: Connection, log: Record, record: MergeRecord) -> None:
    """Write the row of a job on ``log`` in the place of the owner's older one."""
    ensure_log(connection, log)
    of_it = (merge_jobs.c.owner == record.owner, merge_jobs.c.log_id == record.log_id)
    connection.execute(delete(merge_jobs).where(*of_it))
    connection.execute(
        insert(merge_jobs).values(
            log_id=record.log_id,
            owner=record.owner,
            topic=record.topic,
            other=record.other,
            other_topic=record.other_topic,
            state=record.state,
            created_s=record.created_s,
            attempts=record.attempts,
            error_code=None if record.error is None else record.error.code,
            error_message=None if record.error is None else record.error.message,
            result=None if record.result is None else json.dumps(record.result),
        )
    )
