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
    """Error of a failed job: a stable code and one sentence."""

    code: str
    message: str


@dataclass(frozen=True, slots=True, kw_only=True)
class JobRecord(Generic[Q, R]):
    """The newest job of one kind of ``owner`` on a log: its request and, once it is done, its result.

    ``attempts`` is the number of runs that the end of the service interrupted.
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
    """The state and progress of a job in the HTTP interface.

    ``fraction`` is the completed share, ``elapsed_s`` are the seconds since it started (None: not started, or
    elsewhere), ``ahead`` is the number of jobs that are done before it.
    """

    state: JobState
    created_s: float
    error: Failure | None
    fraction: float
    elapsed_s: float | None
    ahead: int


def shared(status: JobStatus) -> dict[str, Any]:
    """Return the common fields of the states of all kinds of jobs, as arguments for creating one."""
    return {field.name: getattr(status, field.name) for field in fields(JobStatus)}


@dataclass(frozen=True, slots=True)
class JobKind(Generic[Q, R]):
    """One kind of jobs: the contents of its records, and the limits of their number.

    ``name`` is used in error codes, ``title`` in the message about an internal error, ``noun`` in those about too many
    jobs. ``places`` is the number of concurrent jobs; ``most_of_owner`` and ``most`` are the maximum numbers of
    unfinished ones of one visitor and of all. A request while a job on the same log is under way joins that job if
    ``joins``, and is refused otherwise.
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
        """Store records in place of the owners' older ones; raises immediately for a deleted log."""

    def writing(self, kind: JobKind[Q, R], record: JobRecord[Q, R]) -> Callable[[Any], None]:
        """Return a function that writes a record in a transaction; raises for a deleted log."""
