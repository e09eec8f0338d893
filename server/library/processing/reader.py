"""Reads logs in workers for small and large ones: one at a time in each, owners in rotation, with a deadline.

If a process dies, the log that it read counts as unreadable.
"""

from __future__ import annotations

import asyncio
import math
import os
import shutil
import tempfile
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from mapper.core.errors import LimitError, MapperError
from mapper.io.logs.summary import LogSummary
from mapper.sensors.planar.options import PlanarCut
from server.jobs.outcome import outcome_of
from server.jobs.process import JobLimits
from server.jobs.workers import PoolWorker, Worker
from server.library.logs.records import Record
from server.library.processing.reading import Job
from server.work.fair_lock import FairLock

LEAST_BYTES_PER_S = 20_000_000  #: of a file; a large one gets one more second per this number of bytes
LEAST_BYTES_PER_CPU_S = 50_000_000  #: likewise for processor time

SMALL_BYTES = 4_000_000  #: size of a file that is read in seconds, and does not wait for a large one
QUICK_S = 2.0  #: processor time after which a small file that keeps others waiting is read with the large ones

T = TypeVar("T")


class SlowReadingError(MapperError):
    """The reading was ended because it keeps others waiting in the place for quick files."""


class Reader:
    """Has logs read by ``worker``, by default a process of this machine. Used from the event loop only.

    One log has ``timeout_s`` seconds, of which ``cpu_s`` of processor time, and more for a large file. Temporary files,
    such as unpacked archives, are in the log's own folder below ``scratch``, which is removed when the job ends, even
    if its process was killed; without ``scratch`` they are in the system's folder.

    A log that may be read elsewhere keeps others waiting until it has used ``quick_s`` seconds of processor time;
    elapsed time would be long for any log on a busy machine. On systems other than Linux the others wait for its end.
    """

    def __init__(
        self,
        *,
        timeout_s: float,
        memory_bytes: int,
        cpu_s: float = math.inf,
        worker: Worker | None = None,
        scratch: Path | None = None,
        quick_s: float = math.inf,
    ) -> None:
        self._scratch = scratch
        self._quick_s = quick_s
        self._owner = ""  #: the owner of the turn
        self._before = (0, 0.0)  #: the process, and its processor time before it was given the log
        self._timeout_s = timeout_s
        self._cpu_s = min(cpu_s, timeout_s)
        self._memory_bytes = memory_bytes
        self._began = time.monotonic()
        self._has_begun = False
        self._turns = FairLock()
        self._worker: Worker = worker or PoolWorker(memory_bytes)

    @property
    def progress(self) -> float:
        """Progress of the log being read, from 0 to 1."""
        return self._worker.progress if self._has_begun else 0.0

    @property
    def worker_pid(self) -> int:
        """Id of the reading process, 0 before it exists."""
        return self._worker.pid

    @asynccontextmanager
    async def turn(self, owner: str) -> AsyncIterator[None]:
        """Wait until a log of ``owner`` may be read, and hold the turn, which is required for calling :meth:`read`."""
        async with self._turns.of(owner):
            # The log counts as being read from here on; the worker's progress is still that of the previous one.
            self._began, self._has_begun, self._owner = time.monotonic(), False, owner
            yield

    async def read(
        self,
        source: Path,
        pack: Path | None,
        topic: str | None = None,
        cut: PlanarCut | None = None,
        *,
        picture: Path | None = None,
        volume: bool = False,
        elsewhere: bool = False,
    ) -> LogSummary:
        """Have ``source`` read, packed into ``pack`` and drawn into ``picture`` if they are given.

        With ``volume``, its clouds are read for a 3D map instead of its scans. The caller holds :meth:`turn`. Raises
        :class:`ReadError` or :class:`LimitError`, also for a worker that died or took too long, and
        :class:`SlowReadingError` for a log that may be read ``elsewhere``.
        """
        target = None if pack is None else str(pack)
        size = await asyncio.to_thread(_size_of, source)
        timeout_s = self._timeout_s + size / LEAST_BYTES_PER_S
        cpu_s = self._cpu_s + size / LEAST_BYTES_PER_CPU_S
        drawn = None if picture is None else str(picture)
        folder = None
        if self._scratch is not None:
            try:
                folder = await asyncio.to_thread(tempfile.mkdtemp, suffix=".reading", dir=self._scratch)
            except OSError as error:
                message = "The log cannot be read now: the server’s disk may be full."
                raise LimitError("log.storage", message) from error
        try:
            limits = JobLimits(timeout_s, cpu_s, self._memory_bytes)
            job = Job(str(source), target, topic, limits, cut, drawn, volume, folder)
            await self._worker.prepare()
            self._before = self.worker_pid, _cpu_s_of(self.worker_pid)
            self._has_begun = True  # it is submitted before anything else runs
            return await outcome_of(self._worker, job, look=self._make_room if elsewhere else None)
        finally:
            if folder is not None:
                await asyncio.to_thread(shutil.rmtree, folder, ignore_errors=True)

    async def _make_room(self) -> None:
        """End a reading that is slow and keeps another owner waiting."""
        if self.cpu_s > self._quick_s and self._turns.keeps_waiting(self._owner):
            self._worker.end()
            raise SlowReadingError("log.slow", "The log takes long to be read, and others wait.")

    @property
    def elapsed_s(self) -> float:
        """Seconds since the turn of the log being read began."""
        return time.monotonic() - self._began

    @property
    def cpu_s(self) -> float:
        """Processor time of the log being read, seconds; 0 if unknown."""
        pid, before = self._before
        return _cpu_s_of(self.worker_pid) - (before if pid == self.worker_pid else 0.0)

    async def close(self) -> None:
        """Cancel the running job and wait until it has ended."""
        await asyncio.to_thread(self._worker.close)


@dataclass(frozen=True, slots=True)
class Readers:
    """The two places in which logs are read; one of them is for files up to :data:`SMALL_BYTES`.

    A small log therefore does not wait for other visitors' large ones, which may take minutes each, nor for ``slow``
    ones: small files, by the id of the log, that took as long as large ones.
    """

    small: Reader
    large: Reader
    slow: set[str] = field(default_factory=set)

    def of(self, record: Record) -> Reader:
        """Return the place for a log."""
        return self.small if record.bytes <= SMALL_BYTES and record.id not in self.slow else self.large

    async def close(self) -> None:
        """Cancel the running jobs and wait until they have ended."""
        await self.small.close()
        await self.large.close()


def _cpu_s_of(pid: int) -> float:
    """Return the processor time of a process, seconds; 0 if unknown."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text("utf-8").rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _size_of(source: Path) -> int:
    """Return the bytes of a file or of the files in a folder; 0 if unknown."""
    try:
        files = source.iterdir() if source.is_dir() else [source]
        return sum(file.stat().st_size for file in files)
    except OSError:
        return 0
