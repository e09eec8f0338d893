"""The database of the records, through SQLAlchemy: SQLite in a file, or PostgreSQL by its URL.

There is one writer: all work runs on one thread in the order of the calls, each call in its own transaction. The tables
are upgraded when the database is opened.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import sqlite3
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, TypeVar

import structlog
from sqlalchemy import URL, Connection, Engine, create_engine, event, inspect, make_url, text
from sqlalchemy.exc import DBAPIError, SQLAlchemyError

from server.library.store.announcing import announce_changes
from server.library.store.migrations import HEAD
from server.library.store.recorded_changes import record_changes
from server.library.store.revision import alembic_config, refuse_unknown
from server.library.store.tables import alembic_version, metadata
from server.storage import RECORDS_FILE, StorageError, disk_full

RESERVE_BYTES = 1 << 18  #: a deletion writes a few pages of 4 KiB, and 32 KiB of the index of the write-ahead log
LEAST_BYTES = 1 << 15  #: a smaller reserve is useless


class Reserve:
    """A file next to the database that reserves disk space until it is released. Any thread, one call at a time.

    It is reserved for deletions, because on a full disk SQLite cannot even record that a row is deleted.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def keep(self) -> None:
        """Reserve the missing space, or as much of it as is available."""
        with contextlib.suppress(OSError):
            handle = os.open(self._path, os.O_WRONLY | os.O_CREAT, 0o600)
            try:
                used, size = os.fstat(handle).st_size, RESERVE_BYTES
                while size >= max(LEAST_BYTES, used + 1):
                    with contextlib.suppress(OSError):
                        os.posix_fallocate(handle, 0, size)
                        break
                    os.ftruncate(handle, used)  # the space reserved before the failure
                    size //= 2
            finally:
                os.close(handle)

    def give_up(self) -> None:
        """Release the space."""
        self._path.unlink(missing_ok=True)


PAGE_BYTES = 4096  #: of SQLite, as it is built
BUSY_S = 5.0  #: longest wait for a lock that another program holds

T = TypeVar("T")

_log = structlog.get_logger(__name__)


class Database:
    """An open database. :meth:`open` blocks and may be called from any thread, the rest from one event loop."""

    def __init__(self, engine: Engine, *, of_workers: bool = False) -> None:
        self._engine = engine
        is_server = engine.dialect.name == "postgresql"
        self.is_shared = is_server or of_workers  #: whether other processes may use it at the same time
        self.file = None if is_server else Path(str(engine.url.database))  #: of SQLite
        self._reserve = None if self.file is None else Reserve(self.file.with_name(f"{self.file.name}-reserve"))
        self.pid = 0  #: of PostgreSQL's process that serves the current connection
        if is_server:
            event.listen(engine, "connect", self._connected)
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="records")

    @classmethod
    def open(cls, url: str | None, folder: Path, *, of_workers: bool = False) -> Database:
        """Open the database at ``url``, None for a file of SQLite in ``folder``, and upgrade its tables.

        ``of_workers``: several processes of one service use a file of SQLite, and each is notified of the others'
        changes. Raises :class:`StorageError`, also for a database that a newer program has written.
        """
        engine = _engine(url, folder)
        opened = cls(engine, of_workers=of_workers)
        if opened.file is not None and opened.file.exists() and not os.access(opened.file, os.R_OK | os.W_OK):
            raise StorageError(
                "library.closed",
                f"The records in {folder} are another account’s: the account of this service may not write them.",
            )
        try:
            _attempt(engine, _check)
            _attempt(engine, bring_up_to_date)
            if opened._reserve is not None:
                opened._reserve.keep()
            if of_workers and opened.file is not None:
                _attempt(engine, record_changes)
        except BaseException:
            opened.close()
            raise
        return opened

    def run(self, work: Callable[[Connection], T]) -> asyncio.Future[T]:
        """Run ``work`` in a transaction, after all previously queued work.

        The future raises :class:`StorageError` if the database fails; then nothing has changed.
        """
        return asyncio.get_running_loop().run_in_executor(self._thread, _attempt, self._engine, work)

    def run_deletion(self, work: Callable[[Connection], T]) -> asyncio.Future[T]:
        """Run ``work``, a deletion or part of one, like :meth:`run`; on a full disk it uses the reserved space."""
        return asyncio.get_running_loop().run_in_executor(self._thread, self._delete, work)

    def _delete(self, work: Callable[[Connection], T]) -> T:
        if self._reserve is None:
            return _attempt(self._engine, work)
        self._reserve.keep()  # some of it may have been released for the last deletion
        try:
            return _attempt(self._engine, work)
        except StorageError as error:
            if error.code != disk_full().code:
                raise
            self._reserve.give_up()
            try:
                done = _attempt(self._engine, work)
                _empty_log(self._engine)
                return done
            finally:
                self._reserve.keep()  # before an upload uses the space

    def now(self, work: Callable[[Connection], T]) -> T:
        """Run ``work`` before any other, and wait for it. Raises :class:`StorageError`."""
        return _attempt(self._engine, work)

    def _connected(self, connection: Any, _: object) -> None:  # noqa: ANN401 - psycopg's, which may not be installed
        self.pid = connection.info.backend_pid

    @property
    def address(self) -> str:
        """The address of a shared database for psycopg, with its password."""
        return self._engine.url.set(drivername="postgresql").render_as_string(hide_password=False)

    def close(self) -> None:
        """Finish the queued work, which may take a while, and close the database."""
        self._thread.shutdown()
        self._engine.dispose()


def _engine(url: str | None, folder: Path) -> Engine:
    where = URL.create("sqlite", database=str(folder / RECORDS_FILE)) if url is None else make_url(url)
    if where.get_backend_name() == "sqlite":
        options = {"timeout": BUSY_S, "check_same_thread": False}
        engine = create_engine(where, pool_size=1, max_overflow=0, connect_args=options)
        event.listen(engine, "connect", _configure_sqlite)
        event.listen(engine, "begin", _begin_sqlite)
        return engine
    where = where.set(drivername="postgresql+psycopg")
    try:
        return create_engine(where, pool_size=1, max_overflow=0, pool_pre_ping=True)
    except ImportError:
        raise StorageError(
            "library.driver", "PostgreSQL needs the package psycopg: pip install 'gridbloom[postgres]'."
        ) from None


def _configure_sqlite(connection: sqlite3.Connection, _: object) -> None:
    connection.isolation_level = None  # SQLAlchemy begins the transactions, so that those that alter tables are atomic
    # Data that is only in the log may enlarge the file when the log is emptied, so it must fit into the reserve.
    pages = f"wal_autocheckpoint={RESERVE_BYTES // PAGE_BYTES}"
    for pragma in ("journal_mode=WAL", "synchronous=NORMAL", "foreign_keys=ON", pages):
        connection.execute(f"PRAGMA {pragma}").close()


def _empty_log(engine: Engine) -> None:
    """Write SQLite's write-ahead log into its file; otherwise each deletion would need more space."""
    connection = engine.raw_connection()
    try:
        with contextlib.suppress(sqlite3.Error):  # there is no space for it, and the log stays as it is
            connection.cursor().execute("PRAGMA wal_checkpoint(TRUNCATE)")
    finally:
        connection.close()


def _begin_sqlite(connection: Connection) -> None:
    connection.exec_driver_sql("BEGIN IMMEDIATE")  # waits for a lock here instead of in the middle of the transaction


def _attempt(engine: Engine, work: Callable[[Connection], T]) -> T:
    try:
        with engine.begin() as connection:
            return work(connection)
    except SQLAlchemyError as error:
        raise _storage_error(error) from error


def _storage_error(error: SQLAlchemyError) -> StorageError:
    """Log an error and return it as a :class:`StorageError`."""
    reason = str(error.orig if isinstance(error, DBAPIError) else error).partition("\n")[0]
    _log.warning("the database of records failed", error=reason)
    if "disk is full" in reason or "disk I/O error" in reason or "No space left" in reason:
        return disk_full()
    if "locked" in reason:
        return StorageError("library.locked", "The records are in use by another program; try again in a moment.")
    if "malformed" in reason or "not a database" in reason:
        return StorageError("library.damaged", "The database of the records is damaged; put its backup in its place.")
    return StorageError("library.unreachable", "The database of the records cannot be used just now; try again later.")


def _check(connection: Connection) -> None:
    """Raise :class:`StorageError` if the database is damaged, before it is changed."""
    if connection.dialect.name == "sqlite":
        problem = connection.execute(text("PRAGMA quick_check(1)")).scalar()
        if problem != "ok":
            raise StorageError(
                "library.damaged", "The database of the records is damaged; put its backup in its place."
            )


def bring_up_to_date(connection: Connection) -> None:
    """Create or upgrade the tables of :mod:`server.library.store.tables`, in the transaction of ``connection``.

    Raises :class:`StorageError` for a database that another version of the program has written.
    """
    if connection.dialect.name == "postgresql":
        connection.execute(text("SELECT pg_advisory_xact_lock(1196574018)"))  # for two services that start at once
    known = set(inspect(connection).get_table_names())
    if known.isdisjoint({alembic_version.name, *metadata.tables}):
        _create(connection)
    else:
        is_versioned = alembic_version.name in known
        version = connection.execute(alembic_version.select()).scalar() if is_versioned else None
        if version != HEAD:
            refuse_unknown(version)
            _upgrade(connection)
    if connection.dialect.name == "postgresql":
        announce_changes(connection)


def _create(connection: Connection) -> None:
    """Create the tables of the newest revision, which saves the import of alembic for an empty database."""
    alembic_version.create(connection)
    metadata.create_all(connection, checkfirst=False)
    connection.execute(alembic_version.insert().values(version_num=HEAD))


def _upgrade(connection: Connection) -> None:
    """Run the revisions after that of the tables."""
    config = alembic_config()
    from alembic import command  # noqa: PLC0415 - start-up: mostly there is nothing to do

    config.attributes["connection"] = connection
    command.upgrade(config, "head")
