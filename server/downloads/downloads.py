"""The low-priority threads that produce downloads, and the state shared by all downloads of a service."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from mapper.core.errors import LimitError
from server.downloads.download_slots import DownloadSlots
from server.downloads.map_snapshots import MapSnapshots
from server.work.priority import lower_priority

T = TypeVar("T")

THREADS = 2  #: for taking snapshots and encoding images

Check = Callable[[], None]


class StoppedError(Exception):
    """The download that a worker thread computes was cancelled."""


@dataclass(frozen=True, slots=True)
class Content:
    """A file: its name, its bytes in pieces, each computed on a worker thread when it is sent, and its size if known.

    ``close`` releases its resources.
    """

    name: str
    pieces: Iterator[bytes]
    nbytes: int | None = None
    close: Callable[[], None] = lambda: None


#: Creates the content of a download, on the event loop, once it holds a slot.
Make = Callable[[], Awaitable[Content]]


class Downloads:
    """The state shared by all downloads of one service. Used on the event loop only."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder  #: for temporary files, which are unnamed
        self.slots = DownloadSlots()
        self.map_snapshots = MapSnapshots()
        self.export_turn = asyncio.Lock()  #: held while a log is exported, because that needs its own grid
        self._threads = ThreadPoolExecutor(THREADS, thread_name_prefix="download", initializer=lower_priority)
        self._long = ThreadPoolExecutor(1, thread_name_prefix="export", initializer=lower_priority)

    async def run(self, work: Callable[[Check], T], *, takes_long: bool = False) -> T:
        """Return ``work(check)`` from a worker thread, from a separate pool if it ``takes_long``.

        ``work`` calls ``check`` often, which raises :class:`StoppedError` once this call was cancelled. A cancelled
        call returns only when the thread has finished, so that its resources are free. Raises :class:`LimitError` if a
        temporary file cannot be written.
        """
        stopped = threading.Event()

        def check() -> None:
            if stopped.is_set():
                raise StoppedError

        executor: Executor = self._long if takes_long else self._threads
        job = executor.submit(work, check)
        waiting = asyncio.wrap_future(job)
        try:
            return await asyncio.shield(waiting)
        except OSError as error:
            raise LimitError("log.storage", "The server could not make the file; its disk may be full.") from error
        except asyncio.CancelledError:
            stopped.set()
            job.cancel()  # if it has not started
            while not waiting.done():
                await asyncio.wait([waiting])
            raise

    async def close(self) -> None:
        """End the threads."""
        for executor in (self._threads, self._long):
            await asyncio.to_thread(executor.shutdown, cancel_futures=True)
