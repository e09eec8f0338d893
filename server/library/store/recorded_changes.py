"""How the workers of one service on one SQLite database notify each other of changes.

SQLite has no NOTIFY. Each worker's connection has temporary triggers that add a row to a table for each changed row;
``PRAGMA data_version`` shows whether another connection has written since, and the rows show what.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterable
from pathlib import Path

from sqlalchemy import Connection

from server.library.store.announcing import ANNOUNCED

KEPT = 4096  #: changes kept for workers that have not seen them yet

_TABLE = """
CREATE TABLE IF NOT EXISTS recorded_changes
  (id INTEGER PRIMARY KEY AUTOINCREMENT, changed TEXT NOT NULL, key TEXT NOT NULL, process INTEGER NOT NULL)
"""

_TRIGGER = """
CREATE TEMP TRIGGER recorded_{what}_of_{table} AFTER {what} ON main.{table} BEGIN
  INSERT INTO recorded_changes (changed, key, process) VALUES ('{table}', {row}.{key}, {process});
  DELETE FROM recorded_changes WHERE id <= last_insert_rowid() - {kept};
END
"""


def record_changes(connection: Connection) -> None:
    """Record the changes by this connection, for as long as it is open."""
    connection.exec_driver_sql(_TABLE)
    for table, key in ANNOUNCED.items():
        for what, row in (("INSERT", "NEW"), ("UPDATE", "NEW"), ("DELETE", "OLD")):
            names = {"table": table, "key": key, "what": what, "row": row, "process": os.getpid(), "kept": KEPT}
            connection.exec_driver_sql(_TRIGGER.format(**names))


class RecordedChanges:
    """Changes of the database at ``path`` by other processes. Used from one thread at a time."""

    def __init__(self, path: Path) -> None:
        self._connection = sqlite3.connect(path, check_same_thread=False, isolation_level=None)
        self._version = -1
        self._seen = 0
        self._is_first = True

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()

    def new(self) -> Iterable[tuple[str, str]] | None:
        """Return the changes since the last call, as tables and keys; None: anything may have changed.

        Raises :class:`sqlite3.Error`.
        """
        (version,) = self._connection.execute("PRAGMA data_version").fetchone()
        if version == self._version and not self._is_first:
            return ()
        query = "SELECT id, changed, key, process FROM recorded_changes WHERE id > ? ORDER BY id"
        rows = self._connection.execute(query, (self._seen,)).fetchall()
        self._version = version
        is_gap = self._is_first or (bool(rows) and rows[0][0] > self._seen + 1)
        self._is_first = False
        if rows:
            self._seen = rows[-1][0]
        return None if is_gap else [(table, key) for _, table, key, process in rows if process != os.getpid()]
