"""The record of a job on a log, and the interface of the store of such records."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Collection, Sequence
from dataclasses import dataclass, fields
from typing import Any, Generic, Literal, Protocol, TypeVar

Q = TypeVar("Q")
R = TypeVar("R")
S = TypeVar("S")

JobState = Literal["none", "queued", "running", "done", "failed", "cancelled"]


@dataclass(frozen=True, slots=True)
class Failure:
    """Error of a job that failed: a stable code and one sentence."""

    code: str
    message: str


@dataclass(frozen=True, slots=True, kw_only=True)
class JobRecord(Generic[Q, R]):
    """The newest job of one kind of ``owner`` on a log: what was requested and, once it is done, the result.

    ``attempts`` counts the runs that the end of the service interrupted.
    """

    log_id: str
    owner: str
    request: Q
    state: JobState = "none"
    created_s: float = 0.0
    attempts: int = 0
    error: Failure | None = None
    result: R | None = None

    @property
    def is_unfinished(self) -> bool:
        """Whether it is queued or running."""
        return self.state in ("queued", "running")


@dataclass(frozen=True, slots=True, kw_only=True)
class JobStatus:
    """What the HTTP interface shows of each job: its state, and how far it is.

    ``fraction`` of it is done, ``elapsed_s`` are seconds since it began (None: not yet, or elsewhere), ``ahead`` the
    jobs that are done before it.
    """

    state: JobState
    created_s: float
    error: Failure | None
    fraction: float
    elapsed_s: float | None
    ahead: int


def shared(status: JobStatus) -> dict[str, Any]:
    """Return the fields that the state of each kind of jobs has, for the making of one."""
    return {field.name: getattr(status, field.name) for field in fields(JobStatus)}


@dataclass(frozen=True, slots=True)
class JobKind(Generic[Q, R]):
    """One kind of jobs: what its records hold, and how many there may be.

    ``name`` is in the codes of errors, ``title`` in the sentence of a defect, ``noun`` in those of too many jobs.
    ``places`` are done at once; ``most_of_owner`` and ``most`` are unfinished ones of one visitor and of all.
    A job that is asked for while one on the same log is under way is that one where ``joins``, and refused otherwise.
    """

    name: str
    title: str
    noun: str
    request: type[Q]
    result: type[R]
    places: int = 1
    most_of_owner: int = 3
    most: int = 50
    joins: bool = True


class JobRows(Protocol):
    """A store of records. All methods raise :class:`server.storage.StorageError` when they are awaited."""

    def load(self, kind: JobKind[Q, R], log_ids: Collection[str] | None = None) -> Awaitable[Sequence[JobRecord[Q, R]]]:
        """Return the records of a kind, oldest first; those of some logs, None: all."""

    def put(self, kind: JobKind[Q, R], records: Sequence[JobRecord[Q, R]]) -> asyncio.Future[None]:
        """Keep records in the place of the owners' older ones; raises at once for a log that is gone."""

    def writing(self, kind: JobKind[Q, R], record: JobRecord[Q, R]) -> Callable[[Any], None]:
        """Return what writes a record in a transaction; raises for a log that is gone."""
