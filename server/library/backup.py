"""A copy of a data folder in one file, made while a service uses it, and the way back.

A tar file of ``library``: the records as SQLite's backup has them, and the files beside them. While the database is
locked for writing, every file gets a second name (a hard link): no log is added or deleted between its record and its
bytes. What takes long, writing the file, follows without the lock. Files are replaced there, never changed.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import sqlite3
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from server.library.store.revision import refuse_newer_file
from server.storage import StorageError, claimed, private_folder

LIBRARY, RECORDS, INCOMING = "library", "library.db", "incoming"
BUSY_S = 30.0  #: how long to wait for a service that writes


def back_up(data_dir: Path, file: Path) -> int:
    """Write all logs, notes, links and what belongs to them into a new ``file``; return its size in bytes.

    Raises :class:`StorageError` where there is nothing to copy, or ``file`` is there, and :class:`OSError`.
    """
    root = data_dir / LIBRARY
    if not (root / RECORDS).is_file():
        raise StorageError("backup.nothing", f"There are no records in {root}.")
    if file.exists():
        raise StorageError("backup.there", f"{file} is there already; a backup overwrites nothing.")
    private_folder(root / INCOMING)  # what is left there by a process that was killed, the service removes
    with tempfile.TemporaryDirectory(dir=root / INCOMING, prefix="backup-") as folder, _refusals():
        copy = Path(folder) / LIBRARY
        _snapshot(root, copy)
        fresh = file.with_name(f"{file.name}.new")
        try:
            with (
                os.fdopen(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as out,
                tarfile.open(fileobj=out, mode="w") as archive,
            ):
                archive.add(copy, LIBRARY)
                archive.close()
                out.flush()
                os.fsync(out.fileno())
            fresh.rename(file)
        finally:
            fresh.unlink(missing_ok=True)
    return file.stat().st_size


def _snapshot(root: Path, copy: Path) -> None:
    """Make ``copy`` of the folder of a library, of one moment."""
    with (
        contextlib.closing(sqlite3.connect(root / RECORDS, timeout=BUSY_S, isolation_level=None)) as lock,
        contextlib.closing(sqlite3.connect(root / RECORDS, timeout=BUSY_S)) as records,
    ):
        lock.execute("BEGIN IMMEDIATE")
        for folder, folders, files in os.walk(root):
            here = copy / Path(folder).relative_to(root)
            here.mkdir(mode=0o700)
            if Path(folder) == root:
                folders.remove(INCOMING)
                files = [name for name in files if not name.startswith(RECORDS)]  # noqa: PLW2901 - without the records
            for name in files:
                with contextlib.suppress(FileNotFoundError):  # what is made again, and is being replaced
                    _link(Path(folder) / name, here / name)
        with contextlib.closing(sqlite3.connect(copy / RECORDS)) as fresh:
            records.backup(fresh)
            fresh.execute("PRAGMA journal_mode=DELETE").close()  # one file


def _link(path: Path, name: Path) -> None:
    try:
        os.link(path, name)
    except FileNotFoundError:
        raise
    except OSError:  # a file system without hard links
        shutil.copy2(path, name)


def restore(file: Path, data_dir: Path) -> None:
    """Put what :func:`back_up` has written into a data folder without records, whole or not at all.

    Raises :class:`StorageError` where a service uses the folder, it has records, or ``file`` is no backup or one of a
    newer program, and :class:`OSError`.
    """
    private_folder(data_dir)
    with claimed(data_dir), tempfile.TemporaryDirectory(dir=data_dir, prefix="restore-") as folder:
        root = data_dir / LIBRARY
        if (root / RECORDS).exists():
            raise StorageError("backup.not_empty", f"There are records in {root}: name a folder without.")
        with _refusals(), tarfile.open(file, "r:") as archive:
            archive.extractall(folder, filter="data")
        found = Path(folder) / LIBRARY
        if not (found / RECORDS).is_file():
            raise _no_backup()
        refuse_newer_file(found / RECORDS)
        if root.exists():
            shutil.rmtree(root)  # of a service that had no records yet
        found.rename(root)


@contextmanager
def _refusals() -> Iterator[None]:
    """Raise errors of SQLite and of the archive as :class:`StorageError`."""
    try:
        yield
    except sqlite3.Error as error:
        raise StorageError("backup.records", f"The records cannot be copied: {error}.") from error
    except tarfile.TarError as error:
        raise _no_backup() from error


def _no_backup() -> StorageError:
    return StorageError("backup.format", "This is no backup of Gridbloom, or not a whole one.")
