"""ROS 2 bags in SQLite (``.db3``), plain, or the whole file gzip or Zstandard.

Source: rosbag2_storage_sqlite3: a table ``topics`` (id, name, type, serialization_format, …) and one ``messages``
(id, topic_id, timestamp, data).

The file is opened read-only and treated as untrusted, following sqlite.org/security.html: no trusted schema, only two
ordinary tables are queried, no order is requested that SQLite would have to sort, and values have a maximum size.

Unused data is not read, because SQLite stores large values in separate pages.

Data that a killed recorder left in a write-ahead log next to the database, in a folder or an archive, is read from a
copy of both. Copies needed for look-ups are cached.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from pathlib import Path
from typing import IO
from urllib.parse import quote

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.bytestream import byte_stream
from mapper.io.logs.archives.unpacking import PIECE, Progress, opened
from mapper.io.logs.containers.container import MAX_NOTES, Container
from mapper.io.logs.containers.kept_copies import KeptCopies, journal_of
from mapper.io.logs.names import printable
from mapper.io.logs.recording.sink import MessageSink
from mapper.io.logs.recording.transcoding import Transcoding

MAGIC = b"SQLite format 3\0"
TABLES = {"topics": {"id", "name", "type", "serialization_format"}, "messages": {"topic_id", "timestamp", "data"}}
DEFINITIONS = {"message_definitions": {"topic_type", "encoding", "encoded_message_definition"}}  #: since ROS 2 Iron


_IN_WAL = (
    "If the recorder was not closed, what it wrote is in the file next to it that ends in -wal; with both in one "
    "folder, sqlite3 FILE.db3 'PRAGMA wal_checkpoint' brings it in."
)


def take_ros2_db3(file: Source, recording: MessageSink, limits: Limits, progress: Progress | None) -> None:
    """Pass the contents of the ROS 2 bag ``file`` to ``recording``; for a damaged bag, the messages before the damage.

    Raises :class:`ReadError` if there are none, and :class:`LimitError`.
    """
    before = recording.taken
    connection, notes, is_journaled = _opened(file, limits, progress)
    if notes is not None:  # read from a copy, which was half of the work
        progress = progress and partial(_second_half, progress)
    try:
        recording.notes += notes or []
        if is_journaled:
            recording.notes.append(
                "The SQLite file keeps a write-ahead log: if the recorder was not closed, what it wrote last is in the "
                "file next to it that ends in -wal, which is not read, and is missing here."
            )
        _take_all(connection, Transcoding(recording), limits, progress)
        if is_journaled and connection.execute("SELECT 1 FROM messages LIMIT 1").fetchone() is None:
            raise ReadError("log.no_scans", "The SQLite file holds no messages.")
    except (sqlite3.Error, UnicodeDecodeError) as error:  # the latter for names of columns and in errors
        if recording.taken == before:
            raise _unreadable(error) from error
        recording.notes.append(f"The SQLite file is damaged ({_reason(error)}): only what precedes is read.")
    except ReadError as error:
        if not is_journaled:
            raise
        raise ReadError(error.code, f"{error.message} {_IN_WAL}") from error
    finally:
        connection.close()


ROS2_DB3 = Container("ROS 2 bag (SQLite)", take_ros2_db3)


def _opened(
    path: Source, limits: Limits, progress: Progress | None
) -> tuple[sqlite3.Connection, list[str] | None, bool]:
    """Return the database, notes on it, and whether it has a write-ahead log that was not read.

    A file that SQLite cannot open directly, because it is compressed, cut or in an archive, is opened as a copy, and so
    is one with a write-ahead log next to it; if no copy is needed, notes is None.
    """
    with opened(path) as file:
        head = file.read(100)
        size = file.seek(0, os.SEEK_END)
    notes: list[str] | None = None
    try:
        merged = _merged(path, limits) if head.startswith(MAGIC) and 2 in head[18:20] else None
        if merged is not None:
            connection, head = merged, b""
            notes = ["What the recorder had not yet moved into the SQLite file is read from the file beside it (-wal)."]
        elif isinstance(path, Path) and head.startswith(MAGIC) and not _is_cut(head, size):
            connection = _connected(path, limits)
        else:
            with _copied(path, limits, progress and partial(_first_half, progress)) as (copy, head, notes):
                connection = _connected(copy, limits)  # remains usable when the copy is unlinked
    except (sqlite3.Error, OverflowError) as error:
        raise _unreadable(error) from error
    return connection, notes, 2 in head[18:20]


def _connected(path: Path, limits: Limits) -> sqlite3.Connection:
    """Open a database for reading within the limits. On failure nothing stays open."""
    # immutable: no locks and no journal, which a hostile file could include
    place = f"file:{quote(str(path.absolute()))}?mode=ro&immutable=1"
    with contextlib.ExitStack() as in_vain:
        connection = sqlite3.connect(place, uri=True, check_same_thread=False)  # cached copies are used sequentially
        in_vain.callback(connection.close)
        connection.execute("PRAGMA schema_version")  # the file is only opened here
        connection.text_factory = lambda data: data.decode("utf-8", "replace")
        connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, limits.max_chunk_bytes)
        connection.setlimit(sqlite3.SQLITE_LIMIT_COLUMN, 100)
        connection.setlimit(sqlite3.SQLITE_LIMIT_EXPR_DEPTH, 50)
        connection.setlimit(sqlite3.SQLITE_LIMIT_ATTACHED, 0)
        for pragma in ("trusted_schema=OFF", "query_only=ON", "cell_size_check=ON", "mmap_size=0", "temp_store=MEMORY"):
            connection.execute(f"PRAGMA {pragma}")
        in_vain.pop_all()
    return connection


def _merged(file: Source, limits: Limits) -> sqlite3.Connection | None:
    """Return a copy of a database merged with the write-ahead log next to it.

    None if there is no such log, no room for the copy, or SQLite rejects it.
    """
    with contextlib.suppress(OSError, sqlite3.Error), tempfile.TemporaryDirectory(prefix="gridbloom-") as folder:
        if (journal := journal_of(file)) is None:
            return None
        copy = Path(folder, "copy.db3")
        for source, target in ((file, copy), (journal, copy.with_name(f"{copy.name}-wal"))):
            with opened(source) as data, target.open("wb") as written:
                shutil.copyfileobj(data, written, PIECE)
        with contextlib.closing(sqlite3.connect(copy)) as writer:
            # Exclusive, so that the index of the log is in memory, not in a file next to the copy.
            for pragma in ("trusted_schema=OFF", "cell_size_check=ON", "locking_mode=EXCLUSIVE", "journal_mode=DELETE"):
                writer.execute(f"PRAGMA {pragma}").fetchall()
        return _connected(copy, limits)  # remains usable when the copy is unlinked
    return None


@contextmanager
def _copied(path: Source, limits: Limits, progress: Progress | None) -> Iterator[tuple[Path, bytes, list[str]]]:
    """Yield a copy of a file's contents that SQLite accepts, its first bytes, and what is missing.

    Raises :class:`LimitError` if there is no room for it.
    """
    try:
        with tempfile.NamedTemporaryFile(prefix="gridbloom-", suffix=".db3") as copy:
            with byte_stream(path, limits, progress) as stream:
                while piece := stream.read(PIECE):
                    copy.write(piece)
                size, notes = stream.at, stream.notes
            copy.seek(0)
            head = copy.read(100)
            if _is_cut(head, size):
                notes.append("The SQLite file ends early: only what precedes is read.")
                # SQLite rejects a file that is shorter than stated, and reads the missing part of a page as zeros.
                pages = size // _page_bytes(head)
                copy.truncate(pages * _page_bytes(head))
                _overwrite(copy.file, 28, pages.to_bytes(4, "big"))
            if size >= 20:
                _overwrite(copy.file, 18, b"\1\1")  # no write-ahead log, because there is none next to the copy
            copy.flush()
            yield Path(copy.name), head, notes
    except OSError as error:
        raise LimitError(
            "log.storage",
            f"A packed or damaged SQLite file is read as a copy, which could not be made: {error.strerror}.",
        ) from error


def _overwrite(file: IO[bytes], at: int, data: bytes) -> None:
    file.seek(at)
    file.write(data)


def _first_half(progress: Progress, share: float) -> None:
    progress(0.5 * share)


def _second_half(progress: Progress, share: float) -> None:
    progress(0.5 + 0.5 * share)


def _reason(error: Exception) -> str:
    """Return SQLite's error message, which may quote the file."""
    return printable(" ".join(str(error).split())[:100]).rstrip(".")


def _unreadable(error: Exception) -> ReadError:
    recover = "what is left of it may be recovered by: sqlite3 OLD.db3 .recover | sqlite3 NEW.db3"
    return ReadError("log.sqlite", f"The SQLite file cannot be read: {_reason(error)}; {recover}.")


def _page_bytes(head: bytes) -> int:
    stated = int.from_bytes(head[16:18], "big")
    return 65536 if stated == 1 else max(stated, 512)


def _is_cut(head: bytes, size: int) -> bool:
    """Return whether a database with this header should have more bytes."""
    return size < _page_bytes(head) * int.from_bytes(head[28:32], "big")


_COPIES = KeptCopies()


def _looked_into(file: Source, limits: Limits) -> AbstractContextManager[sqlite3.Connection]:
    def connected() -> tuple[sqlite3.Connection, int]:
        connection, notes, _ = _opened(file, limits, None)
        size = 0
        with contextlib.suppress(sqlite3.Error):  # for a damaged file, whose error the look-up reports
            size = 0 if notes is None else _database_bytes(connection)
        return connection, size

    return _COPIES.lent(file, connected)


def newest_row(file: Source, topic: str, at_ns: int, limits: Limits) -> tuple[int, str, bytes] | None:
    """Return stamp, type and data of the newest message on ``topic`` at or before ``at_ns``, or else of the first.

    None if there is none. Raises :class:`ReadError` for a file that is not a ROS 2 bag.
    """
    # First find the row, then its data: without an index of times all rows are scanned.
    query = (
        "SELECT messages.rowid FROM messages JOIN topics ON topic_id = topics.id "
        "WHERE name = ? AND serialization_format = 'cdr' AND timestamp"
    )
    whole = "SELECT timestamp, type, data FROM messages JOIN topics ON topic_id = topics.id WHERE messages.rowid = ?"
    with _looked_into(file, limits) as connection:
        try:
            _check_tables(connection)
            sample = connection.execute(f"{query} <= ? ORDER BY timestamp DESC LIMIT 1", (topic, at_ns)).fetchone()
            sample = sample or connection.execute(f"{query} > ? ORDER BY timestamp LIMIT 1", (topic, at_ns)).fetchone()
            row = None if sample is None else connection.execute(whole, sample).fetchone()
        except (sqlite3.Error, UnicodeDecodeError, OverflowError) as error:
            raise _unreadable(error) from error
    if row is None or not isinstance(row[0], int) or not isinstance(row[2], bytes):
        return None
    return row[0], str(row[1]), row[2]


def definition_rows(file: Source, limits: Limits) -> dict[str, tuple[str, str, str]]:
    """Return the type of each topic's messages, and the encoding and text of its definition.

    Bags before ROS 2 Iron have none.
    """
    with _looked_into(file, limits) as connection:
        try:
            _check_tables(connection, TABLES | DEFINITIONS)
            rows = connection.execute(
                "SELECT name, type, encoding, encoded_message_definition FROM message_definitions JOIN topics "
                "ON topic_type = type LIMIT ?",
                (limits.max_topics,),
            ).fetchall()
        except (sqlite3.Error, UnicodeDecodeError, ReadError):
            return {}
    return {printable(row[0]): (row[1], row[2], row[3]) for row in rows if all(isinstance(value, str) for value in row)}


def _other_database(connection: sqlite3.Connection, lacking: str) -> str:
    """Return the description of a database that lacks a table of ROS 2 bags."""
    names = {str(row[0]) for row in connection.execute("SELECT name FROM sqlite_master LIMIT 1000")}
    if {"Node", "Data", "Link"} <= names:
        return (
            "The file is a database of RTAB-Map, not a ROS 2 bag: rtabmap-export writes its cloud (PLY) and its poses; "
            "a log is the bag that it was made of."
        )
    return f"The SQLite file is not a ROS 2 bag: it has no table {lacking!r}."


def _check_tables(connection: sqlite3.Connection, tables: dict[str, set[str]] = TABLES) -> None:
    """Raise :class:`ReadError` for a database whose tables are not those of a ROS 2 bag."""
    for table, needed in tables.items():
        schema = connection.execute("SELECT type, sql FROM sqlite_master WHERE name = ?", (table,)).fetchall()
        # A view, a virtual table or a computed column would execute what the file says.
        if len(schema) != 1 or schema[0][0] != "table" or str(schema[0][1]).upper().startswith("CREATE VIRTUAL"):
            raise ReadError("log.unknown_format", _other_database(connection, table))
        columns = {row[1]: row[6] for row in connection.execute(f"PRAGMA table_xinfo({table})")}
        if not needed <= set(columns) or any(columns[name] for name in needed) or "rowid" in map(str.lower, columns):
            raise ReadError(
                "log.unknown_format", f"The SQLite file is not a ROS 2 bag: its table {table!r} has other columns."
            )


def _database_bytes(connection: sqlite3.Connection) -> int:
    (pages,), (size,) = (connection.execute(f"PRAGMA {name}").fetchone() for name in ("page_count", "page_size"))
    return int(pages) * int(size)


def _take_all(
    connection: sqlite3.Connection, recording: MessageSink, limits: Limits, progress: Progress | None
) -> None:
    _check_tables(connection)
    rows = connection.execute(
        "SELECT id, name, type, serialization_format FROM topics LIMIT ?", (limits.max_topics + 1,)
    )
    keys = []
    for key, name, kind, form in rows:
        if isinstance(key, int):
            keys.append(key)
            recording.channel(key, str(name), str(kind), cdr=True, readable=form == "cdr")
            if form != "cdr" and len(recording.notes) < MAX_NOTES:
                what = f"{printable(str(kind)[:100])} on {printable(str(name)[:100])}"
                recording.notes.append(f"{what}: the messages are encoded as {str(form)!r:.40}, and only cdr is read.")
    topic_ids = ",".join(str(key) for key in keys if recording.wants(key))
    last = 1
    with contextlib.suppress(sqlite3.Error):  # in a cut file, the last row is missing
        last = max(1, connection.execute("SELECT max(rowid) FROM messages").fetchone()[0] or 1)
    # A row has at least five distinct bytes; without this check, cells or pages that a damaged or hostile file
    # references repeatedly would be read for hours.
    room = _database_bytes(connection)
    read = 0
    cursor = connection.execute(
        "SELECT rowid, topic_id, timestamp, length(data), "  # noqa: S608 - the ids are whole numbers, and as such here
        f"CASE WHEN topic_id IN ({topic_ids}) THEN data ELSE x'' END FROM messages ORDER BY rowid"
    )
    for index, (row, key, stamp, size, data) in enumerate(cursor):
        read += 5 + (len(data) if isinstance(data, bytes | str) else 0)
        if read > room:
            raise sqlite3.DatabaseError(f"its messages have more than the {room} bytes of the file")
        if isinstance(key, int) and isinstance(stamp, int) and isinstance(data, bytes):
            recording.take(key, stamp, data, size)
        if progress is not None and index % 256 == 0:
            progress(min(1.0, max(0.0, row / last)))
