"""Copies of SQLite files that cannot be read in place, kept from one look-up to the next of the same files."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from mapper.io.logs.archives.archive import Member, Source

State = tuple[str | int, ...]  #: what tells a file from others, and from what it was before it was changed
MOST_BYTES = 4 << 30  #: of all copies that are kept, on the disk for temporary files


def journal_of(file: Source) -> Source | None:
    """Return the write-ahead log that SQLite left beside a database, in its folder or archive; None without one."""
    if isinstance(file, Member):
        return file.journal if file.journal is not None and file.journal.size > 0 else None
    journal = file.with_name(f"{file.name}-wal")
    return journal if journal.is_file() and journal.stat().st_size > 0 else None


def state_of(file: Source) -> State:
    """Return what tells a database and its write-ahead log from others. Raises :class:`OSError`."""
    journal = journal_of(file)
    return (*_place(file), *(() if journal is None else _place(journal)))


def _place(file: Source) -> State:
    path = file.archive if isinstance(file, Member) else file
    stat = path.stat()
    within = (file.at, file.size) if isinstance(file, Member) else ()
    return (str(path.absolute()), stat.st_ino, stat.st_size, stat.st_mtime_ns, *within)


class KeptCopies:
    """Connections to copies that have no name any more: what is on the disk goes with the last connection to it.

    Those that were used longest ago are closed where all together have more than ``most_bytes``.
    """

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self._most_bytes = most_bytes
        self._kept: dict[State, tuple[sqlite3.Connection, int]] = {}
        self._lock = threading.Lock()

    @contextmanager
    def lent(self, file: Source, opened: Callable[[], tuple[sqlite3.Connection, int]]) -> Iterator[sqlite3.Connection]:
        """Yield the connection to the copy of ``file``, which ``opened`` makes where there is none.

        ``opened`` returns it with the copy's bytes: 0 for a file that is read in place, of which nothing is kept.
        """
        with self._lock:
            try:
                state = state_of(file)
            except OSError:  # whoever opens it says why
                state = ()
            connection, size = self._kept.pop(state) if state in self._kept else opened()
            is_kept = 0 < size <= self._most_bytes and bool(state)
            try:
                yield connection
                if is_kept:
                    self._kept[state] = connection, size
                    self._close_oldest()
            finally:
                if state not in self._kept:
                    connection.close()

    def _close_oldest(self) -> None:
        while sum(size for _, size in self._kept.values()) > self._most_bytes:
            connection, _ = self._kept.pop(next(iter(self._kept)))
            connection.close()
