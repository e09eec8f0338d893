"""Reads the contents of recordings, each once and in a process with limits, and stores them next to the log's pack.

It has its own process, so that a request for contents does not wait for the reading of another log.
"""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from pathlib import Path

from mapper.io.contents.model import Contents
from server.jobs import process
from server.jobs.process import BoundedJob, JobLimits
from server.library.logs.catalogue import Catalogue
from server.library.logs.records import Record
from server.library.packs.contents import StaleContentsError, read_contents, write_contents
from server.library.processing.lookups import Lookups
from server.library.processing.reading_jobs import unstored


@dataclass(frozen=True, slots=True)
class InspectJob(BoundedJob[None]):
    """Read the contents of the recording ``source``, and write them to ``target``."""

    BACKGROUND = True

    source: str
    target: str
    limits: JobLimits

    def compute(self) -> None:
        """Read the contents. Raises :class:`ReadError` or :class:`LimitError`."""
        from mapper.io.contents.inspection import inspect  # noqa: PLC0415 - only the process that reads needs the readers

        contents = inspect(Path(self.source), progress=process.note_progress)
        try:
            write_contents(contents, Path(self.target))
        except OSError:
            raise unstored() from None


class Inspections:
    """The contents of the catalogue's logs. Used from the event loop only."""

    def __init__(self, catalogue: Catalogue, limits: JobLimits) -> None:
        self._catalogue = catalogue
        self._limits = limits
        self.lookups: Lookups[Contents] = Lookups(catalogue, limits.memory_bytes)

    async def contents(self, record: Record, visitor: str, *, address: str = "") -> Contents | float:
        """Return a recording's contents; if they are unknown, start reading them, and return the completed share.

        The inspection ends when no request waits for it. Raises its error, once.
        """
        path = self._catalogue.contents(record.id)
        return await self.lookups.look_up(
            record.id,
            record,
            visitor,
            address,
            lambda source: InspectJob(source, str(path), self._limits),
            lambda: asyncio.to_thread(_stored, path),
        )

    def cancel(self, log_id: str, visitor: str) -> None:
        """End the inspection of a log that ``visitor`` started; see :meth:`Lookups.cancel`."""
        self.lookups.cancel(log_id, visitor)

    async def close(self) -> None:
        """End running inspections, and the process."""
        await self.lookups.close()


def _stored(path: Path) -> Contents | None:
    try:
        return read_contents(path)
    except StaleContentsError:
        return None
