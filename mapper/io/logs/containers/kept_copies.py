"""Cache of copies of SQLite files that cannot be read in place, for repeated look-ups."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from mapper.io.logs.archives.archive import Member, Source

State = tuple[str | int, ...]  #: identifies a file and its state
MOST_BYTES = 4 << 30  #: of all cached copies, on the disk for temporary files


def journal_of(file: Source) -> Source | None:
    """Return the write-ahead log next to a database, in its folder or archive; None without one."""
    if isinstance(file, Member):
        return file.journal if file.journal is not None and file.journal.size > 0 else None
    journal = file.with_name(f"{file.name}-wal")
    return journal if journal.is_file() and journal.stat().st_size > 0 else None


def state_of(file: Source) -> State:
    """Return the identity of a database and its write-ahead log. Raises :class:`OSError`."""
    journal = journal_of(file)
    return (*_place(file), *(() if journal is None else _place(journal)))


def _place(file: Source) -> State:
    path = file.archive if isinstance(file, Member) else file
    stat = path.stat()
    within = (file.at, file.size) if isinstance(file, Member) else ()
    return (str(path.absolute()), stat.st_ino, stat.st_size, stat.st_mtime_ns, *within)


class KeptCopies:
    """Connections to unlinked copies, whose disk space is freed with the last connection.

    The least recently used ones are closed if all together exceed ``most_bytes``.
    """

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self._most_bytes = most_bytes
        self._kept: dict[State, tuple[sqlite3.Connection, int]] = {}
        self._lock = threading.Lock()

    @contextmanager
    def lent(self, file: Source, opened: Callable[[], tuple[sqlite3.Connection, int]]) -> Iterator[sqlite3.Connection]:
        """Yield the connection to the copy of ``file``, which ``opened`` creates if there is none.

        ``opened`` returns it with the copy's size in bytes: 0 for a file read in place, which is not cached.
        """
        with self._lock:
            try:
                state = state_of(file)
            except OSError:  # reported when the file is opened
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
