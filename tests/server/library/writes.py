"""The writes of a library, counted: at the n-th write a test's action runs, for example an error of a full disk.

A write is each piece of an upload, the last of it, the rename that shows it, and each statement that changes a record.
"""

from __future__ import annotations

import asyncio
import errno
import os
import signal
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

import obstore
from sqlalchemy import Engine, event

from server.library.library import Library
from server.settings import Settings
from tests.server.library.small_logs import in_pieces


class Writes:
    """Counter of writes: ``then`` happens at every write after a number of them."""

    def __init__(self, then: Callable[[], object]) -> None:
        self.left: float = float("inf")
        self._then = then

    def count(self) -> None:
        self.left -= 1
        if self.left < 0:
            self._then()


class _Writer:
    def __init__(self, writer: Any, writes: Writes) -> None:
        self._writer, self._writes = writer, writes

    async def write(self, data: bytes) -> None:
        self._writes.count()
        await self._writer.write(data)

    async def close(self) -> None:
        self._writes.count()
        await self._writer.close()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._writer, name)

    async def __aexit__(self, *error: object) -> None:
        await self._writer.__aexit__(*error)


@contextmanager
def counted(then: Callable[[], object]) -> Iterator[Writes]:
    """Count the writes of all libraries."""
    writes = Writes(then)
    open_writer, rename = obstore.open_writer_async, obstore.rename_async

    async def counted_rename(*arguments: Any) -> None:
        writes.count()
        await rename(*arguments)

    def execute(_cursor: Any, statement: str, *_: Any) -> None:
        if statement.split(maxsplit=1)[0] in ("INSERT", "UPDATE", "DELETE"):
            try:
                writes.count()
            except OSError:  # as SQLite says it
                raise sqlite3.OperationalError("database or disk is full") from None

    event.listen(Engine, "do_execute", execute)
    try:
        with (
            patch("obstore.open_writer_async", lambda *a, **k: _Writer(open_writer(*a, **k), writes)),
            patch("obstore.rename_async", counted_rename),
            patch("server.library.uploads.receiver.BATCH_BYTES", 10_000),
            patch("server.library.store.blobs.LOCAL_PART_BYTES", 10_000),
        ):
            yield writes
    finally:
        event.remove(Engine, "do_execute", execute)


def full() -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def upload_and_be_killed(folder: Path, data: bytes, writes_before: int) -> None:
    """Upload ``data``, in a process that is killed before its next write; it ends well where there is no next."""

    async def upload() -> None:
        library = Library(Settings(data_dir=folder))
        await library.start()
        writes.left = writes_before
        await library.put("ann", "new.log", in_pieces(data, 10_000))
        await library._catalogue._store.load()  # it comes after all that was asked before
        os._exit(0)

    with counted(lambda: os.kill(os.getpid(), signal.SIGKILL)) as writes:
        asyncio.run(upload())


def be_killed_by_a_reading(folder: Path) -> None:
    """Run a library in a process that is killed when a reading begins."""

    async def run() -> None:
        library = Library(Settings(data_dir=folder))

        async def kill(*_: object, **__: object) -> None:
            await library._catalogue._store.load()  # what was asked of the database before is done
            os.kill(os.getpid(), signal.SIGKILL)

        with patch.object(library._readers.small, "read", kill):
            await library.start()
            await asyncio.Event().wait()

    asyncio.run(run())
