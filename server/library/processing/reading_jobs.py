"""The jobs that read logs: queued, one at a time, each independent. All methods run on the event loop."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from pathlib import Path

import structlog

from mapper.core.errors import LimitError, MapperError, ReadError
from server.jobs.leases import Lease, Leases, Once
from server.jobs.record import Failure
from server.library.logs.catalogue import INTERRUPTED, UNSTORED, Catalogue
from server.library.logs.records import Record
from server.library.packs.arrays import halves_of
from server.library.processing.reader import Readers, SlowReadingError
from server.storage import StorageError

_log = structlog.get_logger(__name__)

RETRY_S, MOST_RETRY_S = 30.0, 1800.0  #: first and longest pause before repeating a reading that had no disk space
MOST_ATTEMPTS = 3  #: readings of one log that the end of the service may interrupt


class Jobs:
    """The logs queued for ``readers`` or being read; ``room`` returns the number of further bytes allowed."""

    def __init__(self, catalogue: Catalogue, readers: Readers, room: Callable[[], int], leases: Leases) -> None:
        self._leases = leases
        self._closing = False
        self._catalogue = catalogue
        self._readers = readers
        self._room = room
        self._jobs: dict[str, asyncio.Task[None]] = {}
        self._retries: dict[str, tuple[float, asyncio.TimerHandle]] = {}  #: by log, with the preceding pause, seconds

    @property
    def busy(self) -> Sequence[str]:
        """The ids of the queued logs and of those being read."""
        return list(self._jobs)

    def progress(self, record: Record) -> float:
        """Return the completed share of reading a log, here or by another service."""
        return self._leases.elsewhere.get(f"read {record.id}", self._readers.of(record).progress)

    def queue(self, record: Record, *, pack: bool = True) -> Record:
        """Queue a log for reading, once, and return its record in that state; without ``pack`` only examine it."""
        if record.id in self._jobs:
            return self._catalogue.get(record.id) or record
        target = self._catalogue.pack(record.id) if pack else None
        if self._leases.is_shared and record.state == "ready":  # only its pack is missing here
            self._jobs[record.id] = asyncio.create_task(self._pack(record, target))
            return record
        queued = replace(record, state="queued", progress=0.0, error=None)
        self._catalogue.save(queued)
        self._jobs[record.id] = asyncio.create_task(self._read(queued, target))
        return queued

    def adopt(self, record: Record) -> None:
        """Wait for a log queued by another service, and read it if that service does not."""
        if record.id not in self._jobs:
            task = self._read(record, self._catalogue.pack(record.id), adopted=True)
            self._jobs[record.id] = asyncio.create_task(task)

    async def follow(self, log_ids: Collection[str] | None) -> None:
        """Load the changes of other services for some logs, None: for any. Raises ``StorageError``."""
        for record in await self._catalogue.follow(log_ids):
            if record.source == "upload" and record.state in ("queued", "reading"):
                self.adopt(record)
            elif record.state == "failed":  # read elsewhere, or cancelled there
                await self.stop(record.id)
        for log_id in self.busy:
            if self._catalogue.get(log_id) is None:
                await self.stop(log_id)

    def resume(self, record: Record) -> None:
        """Queue a log again whose reading an earlier run of the service did not finish.

        If :data:`MOST_ATTEMPTS` readings were interrupted, it fails instead, because the log may be what ends the
        service.
        """
        if self._leases.is_shared and record.state in ("queued", "reading"):
            self.adopt(record)  # another service may be reading it
        elif record.attempts < MOST_ATTEMPTS:
            self.queue(record)
        elif record.state != "failed":
            self._catalogue.save(interrupted(record))

    async def settled(self, log_id: str) -> None:
        """Wait for the end of the running job."""
        job = self._jobs.get(log_id)
        if job is not None:
            await asyncio.wait([job])  # not the job itself, because cancelling it must not cancel this

    async def stop(self, log_id: str) -> bool:
        """Stop a job, and return whether there was one."""
        job = self._jobs.pop(log_id, None)  # a job that has not started does not remove itself
        if job is None:
            return False
        job.cancel()
        await asyncio.gather(job, return_exceptions=True)
        return True

    async def close(self) -> None:
        """Stop all jobs; the next start queues them again. An orderly stop does not count as a failed attempt."""
        self._closing = True
        for _, timer in self._retries.values():
            timer.cancel()
        jobs = dict(self._jobs)
        for job in jobs.values():
            job.cancel()
        await asyncio.gather(*jobs.values(), return_exceptions=True)

    async def _read(self, record: Record, pack: Path | None, *, adopted: bool = False) -> None:
        """Wait for the reader, read, and store the outcome."""
        log_id = record.id

        def is_open() -> bool:
            known = self._catalogue.get(log_id)
            return known is not None and known.state in ("queued", "reading")

        async def work(lease: Lease) -> None:
            await self._read_here(self._catalogue.get(log_id) or record, pack, lease)

        once = Once(
            f"read {log_id}", lambda: self._readers.of(record).turn(record.owner), is_open,
            lambda: self._catalogue.is_due(log_id), lambda: self._readers.of(record).progress,
        )  # fmt: skip
        try:
            try:
                await self._leases.done_once(once, work, adopted=adopted)
            except SlowReadingError:  # now with the large files
                await self._leases.done_once(once, work)
        except StorageError as error:  # the database of several services is unavailable; another one reads it later
            _log.warning("log not read now", log=log_id, code=error.code)
        finally:
            self._ended(log_id)

    def _ended(self, log_id: str) -> None:
        self._jobs.pop(log_id, None)
        for path in (self._catalogue.pack(log_id), self._catalogue.picture(log_id)):
            for half in halves_of(path):
                half.unlink(missing_ok=True)

    async def _pack(self, record: Record, pack: Path | None) -> None:
        """Read a log with a complete record again for its pack, because another service has read it."""
        reader = self._readers.of(record)
        try:
            async with reader.turn(record.owner), self._catalogue.source(record) as source:
                try:
                    await reader.read(source, pack, picture=self._catalogue.picture(record.id))
                except MapperError as error:
                    raise without_paths(error, source, record.name) from None
            await self._catalogue.publish(record.id)
        except MapperError as error:
            _log.warning("log not packed", log=record.id, code=error.code)
        finally:
            self._ended(record.id)

    async def _read_here(self, record: Record, pack: Path | None, lease: Lease) -> None:
        if self._leases.is_shared and record.attempts >= MOST_ATTEMPTS:
            await self._catalogue.finish(interrupted(record), lease)
            return
        started = time.monotonic()
        try:
            if self._room() < 0:
                raise full()
            record = replace(record, attempts=record.attempts + 1)
            self._catalogue.save(replace(record, state="reading"))
            async with self._catalogue.source(record) as source:
                try:
                    picture = self._catalogue.picture(record.id)
                    summary = await self._readers.of(record).read(source, pack, picture=picture, elsewhere=True)
                except MapperError as error:
                    raise without_paths(error, source, record.name) from None
            await self._catalogue.publish(record.id)
            done = replace(record, state="ready", progress=1.0, summary=summary)
            _log.info("log read", log=record.id, scans=summary.scans, seconds=round(time.monotonic() - started, 3))
        except asyncio.CancelledError:
            known = self._catalogue.get(record.id)
            if self._closing and known is not None and known.state == "reading":
                self._catalogue.save(replace(known, state="queued", attempts=known.attempts - 1))
            raise
        except SlowReadingError:
            self._readers.slow.add(record.id)
            if self._catalogue.get(record.id) is not None:  # not deleted in the meantime
                self._catalogue.save(replace(record, state="queued", attempts=record.attempts - 1))
            raise
        except MapperError as error:
            done = replace(record, state="failed", error=Failure(error.code, error.message))
            _log.info("log refused", log=record.id, code=error.code, message=error.message)
        except OSError as error:  # the system has no process for reading
            refused = unstored()
            done = replace(record, state="failed", error=Failure(refused.code, refused.message))
            _log.warning("log not read now", log=record.id, error=str(error))
        except Exception:  # noqa: BLE001 - whatever it is, it is logged whole and fails this log alone
            # An internal error of a reader must not leave the log in "reading", nor show a traceback to the visitor.
            done = replace(record, state="failed", error=Failure("log.reader_failed", "The reader failed on this log."))
            _log.exception("log reader failed", log=record.id)
        if self._catalogue.get(record.id) is not None:  # not deleted in the meantime
            await self._catalogue.finish(replace(done, attempts=0), lease)
            self._repeat_later(done)

    def _repeat_later(self, record: Record) -> None:
        """Repeat a reading that had no disk space after a pause, which doubles each time."""
        before, _ = self._retries.pop(record.id, (0.0, None))
        if record.error is None or record.error.code != UNSTORED or self._closing:
            return
        pause_s = min(max(RETRY_S, 2.0 * before), MOST_RETRY_S)
        timer = asyncio.get_running_loop().call_later(pause_s, self._repeat, record.id)
        self._retries[record.id] = (pause_s, timer)

    def _repeat(self, log_id: str) -> None:
        record = self._catalogue.get(log_id)
        if record is None or record.error is None or record.error.code != UNSTORED:
            self._retries.pop(log_id, None)  # deleted, or read in the meantime
        else:
            self.queue(record)


def interrupted(record: Record) -> Record:
    """Return the record of a log that is no longer read, because it may be what ends the service."""
    message = f"The service ended {record.attempts} times while it read this log; it is not read again by itself."
    _log.warning("log not read again", log=record.id, attempts=record.attempts)
    return replace(record, state="failed", error=Failure(INTERRUPTED, message))


def without_paths(error: MapperError, source: Path, name: str) -> MapperError:
    """Return the error for the log's owner, with the log's name instead of the file's."""
    return type(error)(error.code, error.message.replace(str(source), name).replace(source.name, name))


def full() -> LimitError:
    """Return the error for a full library."""
    return LimitError("library.full", "The server has no space left for logs; try again later.")


def unstored() -> ReadError:
    """Return the error for a log whose data could not be stored."""
    return ReadError(UNSTORED, "What was read of the log could not be stored; try again.")


def unreadable() -> ReadError:
    """Return the error for a log of which what a process has just read and stored is none that this service reads.

    The processes that read are of the installed version; a service that was not restarted since is of an older one.
    """
    return ReadError(
        "log.other_version",
        "What was read of the log is stored as another version of Gridbloom stores it: restart the service, which is "
        "older than what is installed, then open the log again.",
    )
