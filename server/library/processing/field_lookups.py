"""Reads the numbers of any topic over a whole recording, in a process with limits: what is decoded, others wrote."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mapper.io.contents.model import Series
from server.jobs import process
from server.jobs.process import BoundedJob
from server.library.logs.catalogue import Catalogue
from server.library.logs.records import Record
from server.library.processing.lookups import Lookups

if TYPE_CHECKING:
    from mapper.io.contents.fields import TopicFields

MEMORY_BYTES = 3 << 30  #: address space of the process


@dataclass(frozen=True, slots=True)
class FieldNamesJob(BoundedJob):
    """List the numbers in the first message of each of ``topics``, names and types, of the recording ``source``."""

    source: str
    topics: tuple[tuple[str, str], ...]
    timeout_s: float
    cpu_s: float
    memory_bytes: int

    @property
    def work(self) -> Callable[[FieldNamesJob], list[TopicFields]]:
        """The function that does it."""
        return field_names_job


def field_names_job(job: FieldNamesJob) -> list[TopicFields]:
    """Do the job. Raises :class:`ReadError` or :class:`LimitError`, which cross to the server with their codes."""
    return job.bounded(lambda: _names(job))


def _names(job: FieldNamesJob) -> list[TopicFields]:
    from mapper.io.contents.fields import fields_of  # noqa: PLC0415 - only the process that reads needs the readers

    return fields_of(Path(job.source), job.topics, progress=process.note_progress)


@dataclass(frozen=True, slots=True)
class FieldSeriesJob(BoundedJob):
    """Read all numbers of ``topic``, of type ``kind``, in the recording ``source``."""

    source: str
    topic: str
    kind: str
    timeout_s: float
    cpu_s: float
    memory_bytes: int

    @property
    def work(self) -> Callable[[FieldSeriesJob], Series]:
        """The function that does it."""
        return field_series_job


def field_series_job(job: FieldSeriesJob) -> Series:
    """Do the job. Raises as :func:`field_names_job`."""
    return job.bounded(lambda: _series(job))


def _series(job: FieldSeriesJob) -> Series:
    from mapper.io.contents.fields import field_series  # noqa: PLC0415 - as for the names

    return field_series(Path(job.source), job.topic, job.kind, progress=process.note_progress)


class FieldLookups:
    """Fields of the messages of the catalogue's logs. Used from the event loop only."""

    def __init__(self, catalogue: Catalogue, *, timeout_s: float, cpu_s: float) -> None:
        self._limits = (timeout_s, cpu_s, MEMORY_BYTES)
        self._names: Lookups[list[TopicFields]] = Lookups(catalogue, MEMORY_BYTES)
        self._series: Lookups[Series] = Lookups(catalogue, MEMORY_BYTES)

    async def names(
        self, record: Record, visitor: str, topics: Sequence[tuple[str, str]], *, address: str = ""
    ) -> list[TopicFields] | float:
        """Return the fields of each of ``topics``, or how far finding them is, as :meth:`Lookups.look_up` does."""
        return await self._names.look_up(
            record.id,
            record,
            visitor,
            address,
            lambda source: FieldNamesJob(source, tuple(topics), *self._limits),
        )

    async def series(self, record: Record, visitor: str, topic: str, kind: str, *, address: str = "") -> Series | float:
        """Return all numbers of a topic, or how far reading them is, as :meth:`Lookups.look_up` does."""
        return await self._series.look_up(
            f"{record.id} {topic}",
            record,
            visitor,
            address,
            lambda source: FieldSeriesJob(source, topic, kind, *self._limits),
        )

    async def close(self) -> None:
        """End what runs, and the processes."""
        await self._names.close()
        await self._series.close()
