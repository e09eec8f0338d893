"""The jobs that read logs: queued, one at a time, each with its own end. All methods run on the event loop."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import structlog

from mapper.core.errors import LimitError, MapperError, ReadError
from server.library.catalogue import INTERRUPTED, Catalogue
from server.library.log_reader import Reader
from server.library.records import Failure, Record

_log = structlog.get_logger(__name__)

MOST_ATTEMPTS = 3  #: readings of one log that the end of the service may interrupt


class Jobs:
    """The logs that are queued for ``reader`` or being read; ``room`` returns how many more bytes are allowed."""

    def __init__(self, catalogue: Catalogue, reader: Reader, room: Callable[[], int]) -> None:
        self._catalogue = catalogue
        self._reader = reader
        self._room = room
        self._jobs: dict[str, asyncio.Task[None]] = {}

    @property
    def busy(self) -> Sequence[str]:
        """The ids of the logs that are queued or being read."""
        return list(self._jobs)

    def queue(self, record: Record, *, pack: bool = True) -> Record:
        """Queue a log for reading, once, and return its record in that state; without ``pack`` only to look at it."""
        if record.id in self._jobs:
            return self._catalogue.get(record.id) or record
        queued = replace(record, state="queued", progress=0.0, error=None)
        self._catalogue.save(queued)
        target = self._catalogue.pack(record.id) if pack else None
        self._jobs[record.id] = asyncio.create_task(self._read(queued, target))
        return queued

    def resume(self, record: Record) -> None:
        """Queue again a log whose reading an earlier run of the service did not finish.

        It fails instead where :data:`MOST_ATTEMPTS` readings were interrupted: the log may be what ends the service.
        """
        if record.attempts < MOST_ATTEMPTS:
            self.queue(record)
        elif record.state != "failed":
            message = (
                f"The service ended {record.attempts} times while it read this log; it is not read again by itself."
            )
            self._catalogue.save(replace(record, state="failed", error=Failure(INTERRUPTED, message)))
            _log.warning("log not read again", log=record.id, attempts=record.attempts)

    async def settled(self, log_id: str) -> None:
        """Wait for the end of the running job."""
        job = self._jobs.get(log_id)
        if job is not None:
            await asyncio.wait([job])  # not the job itself: it may be cancelled, and that is not ours to be

    async def stop(self, log_id: str) -> bool:
        """Stop a job, and return whether there was one."""
        job = self._jobs.pop(log_id, None)  # one that has not begun yet does not do it itself
        if job is None:
            return False
        job.cancel()
        await asyncio.gather(job, return_exceptions=True)
        return True

    async def close(self) -> None:
        """Stop all jobs; the next start queues them again. An orderly stop is not an attempt that failed."""
        jobs = dict(self._jobs)
        for job in jobs.values():
            job.cancel()
        await asyncio.gather(*jobs.values(), return_exceptions=True)
        for log_id in jobs:
            record = self._catalogue.get(log_id)
            if record is not None and record.state == "reading":
                self._catalogue.save(replace(record, state="queued", attempts=record.attempts - 1))

    async def _read(self, record: Record, pack: Path | None) -> None:
        """The job: wait for the reader, read, and store the outcome."""
        started = time.monotonic()
        try:
            async with self._reader.turn(record.owner):
                if self._room() < 0:
                    raise full()
                record = replace(record, attempts=record.attempts + 1)
                self._catalogue.save(replace(record, state="reading"))
                started = time.monotonic()
                async with self._catalogue.source(record) as source:
                    try:
                        picture = self._catalogue.picture(record.id)
                        summary = await self._reader.read(source, pack, picture=picture)
                    except MapperError as error:
                        raise without_paths(error, source, record.name) from None
            done = replace(record, state="ready", progress=1.0, summary=summary)
            _log.info("log read", log=record.id, scans=summary.scans, seconds=round(time.monotonic() - started, 3))
        except MapperError as error:
            done = replace(record, state="failed", error=Failure(error.code, error.message))
            _log.info("log refused", log=record.id, code=error.code, message=error.message)
        except Exception:  # noqa: BLE001 - whatever it is, it is logged whole and fails this log alone
            # A reader's own defect must not hang the log in "reading", nor show a traceback to the visitor.
            done = replace(record, state="failed", error=Failure("log.reader_failed", "The reader failed on this log."))
            _log.exception("log reader failed", log=record.id)
        finally:
            self._jobs.pop(record.id, None)
            for path in (self._catalogue.pack(record.id), self._catalogue.picture(record.id)):
                for half in path.parent.glob(f"{path.name}.*.new"):
                    half.unlink(missing_ok=True)
        if self._catalogue.get(record.id) is not None:  # not deleted meanwhile
            self._catalogue.save(replace(done, attempts=0))


def without_paths(error: MapperError, source: Path, name: str) -> MapperError:
    """Return the error for the log's owner: with the log's name instead of the file's."""
    return type(error)(error.code, error.message.replace(str(source), name).replace(source.name, name))


def full() -> LimitError:
    """Return the error for a library without room."""
    return LimitError("library.full", "The server's room for logs is used up; try again later.")


def unstored() -> ReadError:
    """Return the error for a log of which what was read could not be kept."""
    return ReadError("log.storage", "What was read of the log could not be stored; try again.")
