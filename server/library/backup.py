"""A copy of a data folder in one file, made while a service uses it, and the way back.

A tar file of ``library``: the files, and after them the records as SQLite's backup has them. While the database is
locked for writing, every file gets a second name (a hard link) and a reading transaction begins: no log is added or
deleted between its record and its bytes. Copying follows without the lock. Files are replaced there, never changed.
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
UNFINISHED = "restore.unfinished"  #: below a data folder that is claimed, so that no two restore there
BUSY_S = 30.0  #: how long to wait for a service that writes


def back_up(data_dir: Path, file: Path) -> int:
    """Write all logs, notes, links and what belongs to them into a new ``file``; return its size in bytes.

    Raises :class:`StorageError` where there is nothing to copy, or ``file`` is there, and :class:`OSError`.
    """
    root = data_dir / LIBRARY
    if not (root / RECORDS_FILE).is_file():
        raise StorageError("backup.nothing", f"There are no records in {root}.")
    if file.exists():
        raise _is_there(file)
    private_folder(root / INCOMING)  # what is left there by a process that was killed, the service removes
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
    """Yield a file to write, which is then renamed to ``file`` unless that is there."""
    handle, name = tempfile.mkstemp(dir=file.parent, prefix=f".{file.name}.")
    os.close(handle)
    fresh = Path(name)
    try:
        yield fresh
        try:  # renaming would replace it; hard links are not everywhere where a backup is put
            file.touch(mode=0o600, exist_ok=False)
        except FileExistsError as error:
            raise _is_there(file) from error
        fresh.rename(file)
    finally:
        fresh.unlink(missing_ok=True)


def _write(copy: Path, names: Sequence[str], fresh: Path) -> None:
    with fresh.open("wb") as out, tarfile.open(fileobj=out, mode="w") as archive:
        for name in names:  # each by its name: none that has vanished is left out
            archive.add(copy / name, f"{LIBRARY}/{name}", recursive=False)
        archive.close()
        out.flush()
        os.fsync(out.fileno())


def _snapshot(root: Path, copy: Path) -> Sequence[str]:
    """Make ``copy`` of the folder of a library, of one moment; return the names in it, that of the records last."""
    with contextlib.closing(sqlite3.connect(root / RECORDS_FILE, timeout=BUSY_S, isolation_level=None)) as records:
        with contextlib.closing(sqlite3.connect(root / RECORDS_FILE, timeout=BUSY_S, isolation_level=None)) as lock:
            lock.execute("BEGIN IMMEDIATE")
            records.execute("BEGIN").close()
            records.execute("SELECT * FROM sqlite_master").fetchone()  # the transaction begins with the first reading
            names = _linked(root, copy)
        with contextlib.closing(sqlite3.connect(copy / RECORDS_FILE)) as fresh:
            records.backup(fresh)
            fresh.execute("PRAGMA journal_mode=DELETE").close()  # one file
    return [*names, RECORDS_FILE]


def _linked(root: Path, copy: Path) -> Sequence[str]:
    """Give all files but those of the records a second name below ``copy``; return folders and files by their names."""
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
    if not isinstance(error, FileNotFoundError):  # a folder that is made again
        raise error


def _is_linked(path: Path, name: Path) -> bool:
    """Give a file a second name; return False if it has vanished, as what is made again does while it is replaced."""
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
    """Put what :func:`back_up` has written into a data folder without records, whole or not at all.

    Raises :class:`StorageError` where a service uses the folder, it has files, or ``file`` is no backup or one of a
    newer program, and :class:`OSError`.
    """
    private_folder(data_dir)
    with claimed(data_dir):
        root, folder = data_dir / LIBRARY, data_dir / UNFINISHED
        if any(files for _, _, files in os.walk(root, followlinks=True)):  # perhaps of records in PostgreSQL
            raise StorageError("backup.not_empty", f"There are records or logs in {root}: name a folder without.")
        if folder.exists():
            shutil.rmtree(folder)  # of one that was killed
        folder.mkdir(mode=0o700)
        try:
            _extract(file, folder)
            for empty, _, _ in os.walk(root, topdown=False):  # of a service that had no records yet
                Path(empty).rmdir()
            (folder / LIBRARY).rename(root)
        finally:
            shutil.rmtree(folder)


def _extract(file: Path, folder: Path) -> None:
    """Put the files of a whole backup into ``folder``."""
    with _refusals(), tarfile.open(file, "r:") as archive:
        members = archive.getmembers()
        if (
            members[-1].name != f"{LIBRARY}/{RECORDS_FILE}"
        ):  # a file that is cut between two members ends as a whole one
            raise _no_backup()
        archive.extractall(folder, filter="data")
    records = folder / LIBRARY / RECORDS_FILE
    if not records.is_file():
        raise _no_backup()
    refuse_newer_file(records)


@contextmanager
def _refusals() -> Iterator[None]:
    """Raise errors of SQLite and of the archive as :class:`StorageError`."""
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
