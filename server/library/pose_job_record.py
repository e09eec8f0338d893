"""The record of a job that gives a log another trajectory, and its row in the database."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from sqlalchemy import Connection, Table, delete, insert, select

from server.library.log_rows import ensure_log
from server.library.records import Failure, Record

_TEXTS = ("result", "parameters", "cut")  # columns of JSON

JobState = Literal["none", "queued", "running", "done", "failed", "cancelled"]


@dataclass(frozen=True, slots=True)
class PoseJobRecord:
    """A job of ``owner`` that makes poses of a log from those of ``trajectory``.

    ``attempts`` counts the runs that the end of the service interrupted; ``result`` is what the HTTP interface shows of
    a job that is done. ``parameters`` are the kind's own, as its ``checked`` returns them, ``cut`` how the scans are
    cut out of clouds and depth images (None: as by default).
    """

    log_id: str
    owner: str
    topic: str | None
    trajectory: str | None
    state: JobState
    created_s: float
    attempts: int = 0
    error: Failure | None = None
    result: dict[str, Any] | None = None
    parameters: dict[str, Any] = field(default_factory=dict)
    cut: dict[str, float] | None = None

    @property
    def is_unfinished(self) -> bool:
        """Whether it is queued or running."""
        return self.state in ("queued", "running")

    def public(self) -> dict[str, Any]:
        """Return what the HTTP interface shows."""
        return {
            "log": self.log_id,
            "topic": self.topic,
            "odometry": self.trajectory,
            "parameters": self.parameters,
            "state": self.state,
            "created_s": self.created_s,
            "error": None if self.error is None else asdict(self.error),
            "result": self.result,
        }


def load_job_records(connection: Connection, table: Table) -> Sequence[PoseJobRecord]:
    """Return all rows of a kind's table, oldest first."""
    found = []
    for row in connection.execute(select(table).order_by(table.c.created_s)):
        values = dict(row._mapping)  # noqa: SLF001 - SQLAlchemy's public name for it
        code, message = values.pop("error_code"), values.pop("error_message")
        error = None if code is None else Failure(code, message or "")
        result, parameters, cut = (None if text is None else json.loads(text) for text in map(values.pop, _TEXTS))
        found.append(PoseJobRecord(**values, error=error, result=result, parameters=parameters or {}, cut=cut))
    return found


def put_job_record(connection: Connection, table: Table, log: Record, record: PoseJobRecord) -> None:
    """Write the row of a job on ``log`` in the place of the owner's older one."""
    ensure_log(connection, log)
    of_it = (table.c.owner == record.owner, table.c.log_id == record.log_id)
    connection.execute(delete(table).where(*of_it))
    connection.execute(
        insert(table).values(
            log_id=record.log_id,
            owner=record.owner,
            topic=record.topic,
            trajectory=record.trajectory,
            state=record.state,
            created_s=record.created_s,
            attempts=record.attempts,
            error_code=None if record.error is None else record.error.code,
            error_message=None if record.error is None else record.error.message,
            result=None if record.result is None else json.dumps(record.result),
            parameters=json.dumps(record.parameters),
            cut=None if record.cut is None else json.dumps(record.cut),
        )
    )
