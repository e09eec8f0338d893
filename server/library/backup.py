"""Backup of a data folder in one file, made while a service uses it, and its restoration.

The backup is a tar file of ``library``: the files, followed by the records from SQLite's backup. While the database is
locked for writing, every file gets a second name (a hard link) and a read transaction begins, so that no log is added
or deleted between its record and its bytes. Copying follows without the lock. Files there are replaced, never modified.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import sqlite3
import tarfile
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from server.library.store.revision import refuse_newer_file
from server.storage import RECORDS_FILE, StorageError, claimed, private_folder

LIBRARY, INCOMING = "library", "incoming"
UNFINISHED = "restore.unfinished"  #: below a claimed data folder, so that no two processes restore there
BUSY_S = 30.0  #: how long to wait for a service that writes


def back_up(data_dir: Path, file: Path) -> int:
    """Write all logs, notes, links and their data into a new ``file``; return its size in bytes.

    Raises :class:`StorageError` if there is nothing to copy, or ``file`` exists, and :class:`OSError`.
    """
    root = data_dir / LIBRARY
    if not (root / RECORDS_FILE).is_file():
        raise StorageError("backup.nothing", f"There are no records in {root}.")
    if file.exists():
        raise _is_there(file)
    private_folder(root / INCOMING)  # the service removes what a killed process leaves there
    with tempfile.TemporaryDirectory(dir=root / INCOMING, prefix="backup-") as folder, _refusals():
        copy = Path(folder) / LIBRARY
        try:
            names = _snapshot(root, copy)
            with _new(file) as fresh:
                _write(copy, names, fresh)
        except (FileNotFoundError, sqlite3.Error) as error:
            if copy.exists():
                raise
            raise StorageError(
                "backup.started",
                f"A service was started meanwhile, which empties {root / INCOMING}. Make the backup again.",
            ) from error
    return file.stat().st_size


@contextmanager
def _new(file: Path) -> Iterator[Path]:
    """Yield a file to write, which is then renamed to ``file`` unless that exists."""
    handle, name = tempfile.mkstemp(dir=file.parent, prefix=f".{file.name}.")
    os.close(handle)
    fresh = Path(name)
    try:
        yield fresh
        try:  # renaming would replace it; not every file system for backups has hard links
            file.touch(mode=0o600, exist_ok=False)
        except FileExistsError as error:
            raise _is_there(file) from error
        fresh.rename(file)
    finally:
        fresh.unlink(missing_ok=True)


def _write(copy: Path, names: Sequence[str], fresh: Path) -> None:
    with fresh.open("wb") as out, tarfile.open(fileobj=out, mode="w") as archive:
        for name in names:  # by name, so that a vanished file causes an error
            archive.add(copy / name, f"{LIBRARY}/{name}", recursive=False)
        archive.close()
        out.flush()
        os.fsync(out.fileno())


def _snapshot(root: Path, copy: Path) -> Sequence[str]:
    """Make ``copy`` a snapshot of a library's folder; return the names in it, that of the records last."""
    with contextlib.closing(sqlite3.connect(root / RECORDS_FILE, timeout=BUSY_S, isolation_level=None)) as records:
        with contextlib.closing(sqlite3.connect(root / RECORDS_FILE, timeout=BUSY_S, isolation_level=None)) as lock:
            lock.execute("BEGIN IMMEDIATE")
            records.execute("BEGIN").close()
            records.execute("SELECT * FROM sqlite_master").fetchone()  # the transaction begins with the first read
            names = _linked(root, copy)
        with contextlib.closing(sqlite3.connect(copy / RECORDS_FILE)) as fresh:
            records.backup(fresh)
            fresh.execute("PRAGMA journal_mode=DELETE").close()  # a single file
    return [*names, RECORDS_FILE]


def _linked(root: Path, copy: Path) -> Sequence[str]:
    """Hard-link all files except those of the records below ``copy``; return folders and files by name."""
    names: list[str] = []
    for folder, folders, files in os.walk(root, onerror=_unread, followlinks=True):  # perhaps a link to a larger disk
        below = Path(folder).relative_to(root)
        here = copy / below
        here.mkdir(mode=0o700)
        if Path(folder) == root:
            folders.remove(INCOMING)
            files = [name for name in files if not name.startswith(RECORDS_FILE)]  # noqa: PLW2901 - without the records
        else:
            names.append(str(below))
        names.extend(str(below / name) for name in files if _is_linked(Path(folder) / name, here / name))
    return names


def _unread(error: OSError) -> None:
    if not isinstance(error, FileNotFoundError):  # a folder that is created again
        raise error


def _is_linked(path: Path, name: Path) -> bool:
    """Hard-link a file; return False if it has vanished, like derived files while they are replaced."""
    try:
        os.link(os.path.realpath(path), name)
    except FileNotFoundError:
        if not name.parent.is_dir():
            raise
        return False
    except OSError as error:
        raise StorageError(
            "backup.links",
            f"{path} gets no second name below {INCOMING}: it is on another disk, or its file system has no hard links "
            f"({error.strerror}). End the service, and copy the data folder by other means.",
        ) from error
    return True


def restore(file: Path, data_dir: Path) -> None:
    """Restore a backup of :func:`back_up` into a data folder without records, completely or not at all.

    Raises :class:`StorageError` if a service uses the folder, it has files, or ``file`` is no backup or one of a newer
    program, and :class:`OSError`.
    """
    private_folder(data_dir)
    with claimed(data_dir):
        root, folder = data_dir / LIBRARY, data_dir / UNFINISHED
        if any(files for _, _, files in os.walk(root, followlinks=True)):  # perhaps of records in PostgreSQL
            raise StorageError("backup.not_empty", f"There are records or logs in {root}: name a folder without.")
        if folder.exists():
            shutil.rmtree(folder)  # of a killed process
        folder.mkdir(mode=0o700)
        try:
            _extract(file, folder)
            for empty, _, _ in os.walk(root, topdown=False):  # of a service that had no records yet
                Path(empty).rmdir()
            (folder / LIBRARY).rename(root)
        finally:
            shutil.rmtree(folder)


def _extract(file: Path, folder: Path) -> None:
    """Extract the files of a complete backup into ``folder``."""
    with _refusals(), tarfile.open(file, "r:") as archive:
        members = archive.getmembers()
        if (
            members[-1].name != f"{LIBRARY}/{RECORDS_FILE}"
        ):  # a file truncated between two members ends like a complete one
            raise _no_backup()
        archive.extractall(folder, filter="data")
    records = folder / LIBRARY / RECORDS_FILE
    if not records.is_file():
        raise _no_backup()
    refuse_newer_file(records)


@contextmanager
def _refusals() -> Iterator[None]:
    """Convert errors of SQLite and of the archive to :class:`StorageError`."""
    try:
        yield
    except sqlite3.Error as error:
        raise StorageError("backup.records", f"The records cannot be copied: {error}.") from error
    except tarfile.TarError as error:
        raise _no_backup() from error


def _is_there(file: Path) -> StorageError:
    return StorageError("backup.there", f"{file} is there already; a backup overwrites nothing.")


def _no_backup() -> StorageError:
    return StorageError("backup.format", "This is no backup of Gridbloom, or not a whole one.")
