"""Reads the numbers of any topic of a recording in a process with limits, because the data is untrusted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from mapper.io.contents.model import Series
from server.jobs import process
from server.jobs.process import BoundedJob, JobLimits
from server.library.logs.catalogue import Catalogue
from server.library.logs.records import Record
from server.library.processing.lookups import Lookups

if TYPE_CHECKING:
    from mapper.io.contents.fields import TopicFields

MEMORY_BYTES = 3 << 30  #: address space of the process


@dataclass(frozen=True, slots=True)
class FieldNamesJob(BoundedJob["list[TopicFields]"]):
    """List the numbers in the first message of each of ``topics``, names and types, of the recording ``source``."""

    source: str
    topics: tuple[tuple[str, str], ...]
    limits: JobLimits

    def compute(self) -> list[TopicFields]:
        """Return the names. Raises :class:`ReadError` or :class:`LimitError`."""
        from mapper.io.contents.fields import fields_of  # noqa: PLC0415 - only the process that reads needs the readers

        return fields_of(Path(self.source), self.topics, progress=process.note_progress)


@dataclass(frozen=True, slots=True)
class FieldSeriesJob(BoundedJob[Series]):
    """Read all numbers of ``topic``, of type ``kind``, in the recording ``source``."""

    source: str
    topic: str
    kind: str
    limits: JobLimits

    def compute(self) -> Series:
        """Return the numbers. Raises :class:`ReadError` or :class:`LimitError`."""
        from mapper.io.contents.fields import field_series  # noqa: PLC0415 - as for the names

        return field_series(Path(self.source), self.topic, self.kind, progress=process.note_progress)


class FieldLookups:
    """Fields of the messages of the catalogue's logs. Used from the event loop only."""

    def __init__(self, catalogue: Catalogue, limits: JobLimits) -> None:
        self._limits = replace(limits, memory_bytes=MEMORY_BYTES)
        self._names: Lookups[list[TopicFields]] = Lookups(catalogue, MEMORY_BYTES)
        self._series: Lookups[Series] = Lookups(catalogue, MEMORY_BYTES)

    async def names(
        self, record: Record, visitor: str, topics: Sequence[tuple[str, str]], *, address: str = ""
    ) -> list[TopicFields] | float:
        """Return the fields of each of ``topics``, or the completed share of reading; see :meth:`Lookups.look_up`."""
        return await self._names.look_up(
            record.id,
            record,
            visitor,
            address,
            lambda source: FieldNamesJob(source, tuple(topics), self._limits),
        )

    async def series(self, record: Record, visitor: str, topic: str, kind: str, *, address: str = "") -> Series | float:
        """Return all numbers of a topic, or the completed share of reading them; see :meth:`Lookups.look_up`."""
        return await self._series.look_up(
            f"{record.id} {topic}",
            record,
            visitor,
            address,
            lambda source: FieldSeriesJob(source, topic, kind, self._limits),
        )

    async def close(self) -> None:
        """End running jobs and the processes."""
        await self._names.close()
        await self._series.close()
