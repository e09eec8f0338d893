"""A data folder copied while its service runs, restored elsewhere, and read there; and one of a newer program."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import shutil
import sqlite3
import subprocess
import sys
import tarfile
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import httpx
import pytest

from server.library import backup
from server.library.backup import back_up, restore
from server.library.store.migrations import HEAD
from server.library.store.revision import refuse_newer_file
from server.storage import StorageError
from tests.marks import also_long
from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, once_read

VISITOR = "someone".ljust(24, "_")
GRIDBLOOM = [sys.executable, "-c", "from server.cli import main; main()"]


@contextlib.contextmanager
def serving(folder: Path, *options: str) -> Iterator[httpx.Client]:
    """A visitor of a service on this folder."""
    command = [*GRIDBLOOM, "serve", "--port", "0", "--data-dir", str(folder), *options]
    quiet = os.environ | {"GRIDBLOOM_COMPILE_AHEAD": "false"}
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=quiet)
    assert process.stdout is not None
    try:
        port = int(process.stdout.readline().rsplit(":", 1)[1].strip("/\n"))
        address = f"http://127.0.0.1:{port}"
        with httpx.Client(base_url=address, timeout=PATIENCE_S, cookies={"gridbloom_visitor": VISITOR}) as visitor:
            yield visitor
    finally:
        process.terminate()
        process.wait(PATIENCE_S)
        process.stdout.close()


def uploaded(visitor: httpx.Client, name: str, scans: int) -> str:
    log = visitor.put("/api/logs", params={"name": name}, content=carmen(scans)).raise_for_status().json()["id"]
    assert once_read(visitor, log)["state"] == "ready"
    return str(log)


def opened(visitor: httpx.Client, log: str) -> str:
    return str(visitor.post("/api/sessions", json={"kind": "log", "log": log}).raise_for_status().json()["id"])


def contents(folder: Path) -> dict[str, tuple[int, str]]:
    """When each file was changed, and its digest."""
    return {
        str(path.relative_to(folder)): (path.stat().st_mtime_ns, hashlib.sha256(path.read_bytes()).hexdigest())
        for path in folder.rglob("*")
        if path.is_file()
    }


@pytest.mark.parametrize("options", [(), *also_long(("--workers", "2"))])
def test_what_a_running_service_has_is_read_in_another_folder(tmp_path: Path, options: tuple[str, ...]) -> None:
    file = tmp_path / "kept.tar"
    poses = "".join(f"{1.0 + n} {0.1 * n} 0 0 0 0 0 1\n" for n in range(8))
    with serving(tmp_path / "data", *options) as visitor:
        log = uploaded(visitor, "kept.log", 8)
        view = opened(visitor, log)
        visitor.post(f"/api/sessions/{view}/notes", json={"text": "a door", "at_s": 1.0, "scan": 5}).raise_for_status()
        visitor.put(f"/api/logs/{log}/tags", json={"tags": ["hall"]}).raise_for_status()
        visitor.put(f"/api/logs/{log}/trajectories/mine", content=poses).raise_for_status()
        token = visitor.post(f"/api/sessions/{view}/links", json={}).raise_for_status().json()["token"]
        picture = visitor.get(f"/api/sessions/{view}/map.png").raise_for_status().content
        listed = visitor.get("/api/logs").raise_for_status().json()
        command = [*GRIDBLOOM, "backup", str(file), "--data-dir", str(tmp_path / "data")]
        subprocess.run(command, check=True, timeout=PATIENCE_S)
        visitor.delete(f"/api/logs/{log}").raise_for_status()  # what comes later is not in it
    assert file.stat().st_mode & 0o077 == 0
    command = [*GRIDBLOOM, "restore", str(file), "--data-dir", str(tmp_path / "elsewhere")]
    subprocess.run(command, check=True, timeout=PATIENCE_S)
    assert sorted(path.name for path in (tmp_path / "elsewhere").iterdir()) == ["library"]
    with serving(tmp_path / "elsewhere", *options) as visitor:
        found = visitor.get("/api/logs").raise_for_status().json()
        assert [(one["name"], one["id"], one["tags"]) for one in found["logs"]] == [
            (one["name"], one["id"], one["tags"]) for one in listed["logs"]
        ]
        assert once_read(visitor, log)["state"] == "ready"
        view = opened(visitor, log)
        assert [one["text"] for one in visitor.get(f"/api/sessions/{view}/notes").json()["notes"]] == ["a door"]
        assert visitor.get(f"/api/sessions/{view}/map.png").raise_for_status().content == picture
        assert len(visitor.get(f"/api/logs/{log}/trajectories/mine").raise_for_status().text.splitlines()) >= 8
        assert visitor.get(f"/api/shared/{token}").raise_for_status().json()


def test_every_record_has_its_bytes_however_many_logs_come_and_go(tmp_path: Path) -> None:
    with serving(tmp_path / "data") as visitor:
        kept = {
            visitor.put("/api/logs", params={"name": "b.log"}, content=carmen(n)).raise_for_status().json()["id"]
            for n in (20, 21)
        }
        over = threading.Event()

        def come_and_go() -> None:
            with httpx.Client(base_url=visitor.base_url, timeout=PATIENCE_S) as other:
                for scans in range(5, 10_000):
                    if over.is_set():
                        return
                    log = other.put("/api/logs", params={"name": "a.log"}, content=carmen(5 + scans % 7))
                    other.delete(f"/api/logs/{log.raise_for_status().json()['id']}").raise_for_status()

        coming = threading.Thread(target=come_and_go)
        coming.start()
        try:
            for n in range(5):
                back_up(tmp_path / "data", tmp_path / f"{n}.tar")
        finally:
            over.set()
            coming.join()
    for n in range(5):
        restore(tmp_path / f"{n}.tar", tmp_path / f"of-{n}")
        library = tmp_path / f"of-{n}" / "library"
        with contextlib.closing(sqlite3.connect(library / "library.db")) as records:
            digests = dict(records.execute("SELECT id, sha256 FROM logs WHERE source = 'upload'"))
        assert kept <= digests.keys()
        for digest in digests.values():
            assert hashlib.sha256((library / "blobs" / digest).read_bytes()).hexdigest() == digest


def refused(code: str, file: Path, folder: Path) -> None:
    with pytest.raises(StorageError) as caught:
        restore(file, folder)
    assert caught.value.code == code


def test_what_is_no_backup_and_folders_with_records_are_refused(tmp_path: Path) -> None:
    small_library(tmp_path / "data")
    file = tmp_path / "kept.tar"
    back_up(tmp_path / "data", file)
    before = contents(tmp_path / "data")
    refused("backup.not_empty", file, tmp_path / "data")
    assert contents(tmp_path / "data") == before
    with pytest.raises(StorageError, match="overwrites nothing"):
        back_up(tmp_path / "data", file)
    with pytest.raises(StorageError, match="no records"):
        back_up(tmp_path / "nowhere", tmp_path / "other.tar")
    (tmp_path / "noise.tar").write_bytes(b"noise" * 1000)
    (tmp_path / "half.tar").write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    with tarfile.open(tmp_path / "outside.tar", "w") as archive:
        archive.add(file, "../outside")
    for name in ("noise.tar", "half.tar", "outside.tar"):
        refused("backup.format", tmp_path / name, tmp_path / "new")
        assert not list((tmp_path / "new").iterdir())
    assert not (tmp_path / "outside").exists()


def small_library(folder: Path) -> Path:
    """Return a library of one file and records of the newest revision."""
    root = folder / "library"
    (root / "blobs").mkdir(parents=True)
    (root / "blobs" / "log").write_bytes(b"log")
    with contextlib.closing(sqlite3.connect(root / "library.db")) as records, records:
        records.execute("CREATE TABLE alembic_version (version_num)")
        records.execute("INSERT INTO alembic_version VALUES (?)", [HEAD])
    return root


def test_a_backup_that_is_cut_anywhere_is_refused(tmp_path: Path) -> None:
    small_library(tmp_path / "data")
    file = tmp_path / "kept.tar"
    back_up(tmp_path / "data", file)
    with tarfile.open(file) as archive:
        starts = [member.offset for member in archive.getmembers()]
        assert archive.getnames() == ["library/blobs", "library/blobs/log", "library/library.db"]
    cut = tmp_path / "cut.tar"
    for size in (*starts, starts[-1] + 512, starts[-1] + 1024):
        cut.write_bytes(file.read_bytes()[:size])
        refused("backup.format", cut, tmp_path / "new")
    with tarfile.open(cut, "w") as archive:  # whole but for its last files
        archive.add(tmp_path / "data" / "library" / "library.db", "library/library.db")
        archive.add(tmp_path / "data" / "library" / "blobs", "library/blobs")
    refused("backup.format", cut, tmp_path / "new")
    restore(file, tmp_path / "new")
    assert (tmp_path / "new" / "library" / "blobs" / "log").read_bytes() == b"log"


def test_logs_without_records_beside_them_are_kept_and_empty_folders_replaced(tmp_path: Path) -> None:
    small_library(tmp_path / "data")
    back_up(tmp_path / "data", tmp_path / "kept.tar")
    other = tmp_path / "other"
    (other / "library" / "packs" / "a").mkdir(parents=True)
    log = other / "library" / "log"
    log.touch()
    refused("backup.not_empty", tmp_path / "kept.tar", other)  # the records are in PostgreSQL
    assert log.exists()
    log.unlink()
    (other / "restore.unfinished" / "library").mkdir(parents=True)  # of a command that was killed
    restore(tmp_path / "kept.tar", other)
    assert [path.name for path in other.iterdir()] == ["library"]
    assert sorted(path.name for path in (other / "library").iterdir()) == ["blobs", "library.db"]


def test_a_folder_that_is_a_link_is_in_the_backup(tmp_path: Path) -> None:
    root = small_library(tmp_path / "data")
    (root / "blobs").rename(tmp_path / "disk")
    (root / "blobs").symlink_to(tmp_path / "disk")
    back_up(tmp_path / "data", tmp_path / "kept.tar")
    restore(tmp_path / "kept.tar", tmp_path / "new")
    assert (tmp_path / "new" / "library" / "blobs" / "log").read_bytes() == b"log"


def test_without_hard_links_nothing_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = small_library(tmp_path / "data")

    def another_disk(path: str, name: Path) -> None:
        raise OSError(errno.EXDEV, "Invalid cross-device link", path, None, str(name))

    monkeypatch.setattr(os, "link", another_disk)
    with pytest.raises(StorageError, match="another disk") as caught:
        back_up(tmp_path / "data", tmp_path / "kept.tar")
    assert str(root / "blobs" / "log") in caught.value.message
    assert [path.name for path in tmp_path.iterdir()] == ["data"]


def test_files_beside_a_backup_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    small_library(tmp_path / "data")
    file, other = tmp_path / "kept.tar", tmp_path / "kept.tar.new"
    other.write_text("of somebody else")
    add = tarfile.TarFile.add

    def meanwhile(*given: Any, **options: Any) -> None:
        file.write_text("of another backup")
        add(*given, **options)

    with monkeypatch.context() as patched:
        patched.setattr(tarfile.TarFile, "add", meanwhile)
        with pytest.raises(StorageError, match="overwrites nothing"):
            back_up(tmp_path / "data", file)
    assert file.read_text() == "of another backup"
    file.unlink()
    back_up(tmp_path / "data", file)
    assert other.read_text() == "of somebody else"
    assert {path.name for path in tmp_path.iterdir()} == {"data", file.name, other.name}


def test_writing_goes_on_while_records_and_files_are_copied(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = small_library(tmp_path / "data")
    with contextlib.closing(sqlite3.connect(root / "library.db", timeout=0)) as service:
        service.execute("PRAGMA journal_mode=WAL")
        add = backup._linked

        def linked(*given: Path) -> Sequence[str]:
            with pytest.raises(sqlite3.OperationalError, match="locked"):
                service.execute("BEGIN IMMEDIATE")
            return add(*given)

        connect = sqlite3.connect

        def connected(path: Path, **options: Any) -> Any:
            if path != root / "library.db":  # the copy of the records: what comes now is not in it
                with service:
                    service.execute("UPDATE alembic_version SET version_num = '9999'")
                (root / "blobs" / "log").unlink()
            return connect(path, **options)

        monkeypatch.setattr(backup, "_linked", linked)
        monkeypatch.setattr(sqlite3, "connect", connected)
        back_up(tmp_path / "data", tmp_path / "kept.tar")
        monkeypatch.undo()
    restore(tmp_path / "kept.tar", tmp_path / "new")
    assert (tmp_path / "new" / "library" / "blobs" / "log").exists()


def test_a_service_that_starts_meanwhile_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = small_library(tmp_path / "data")

    def emptied(*given: Path) -> Sequence[str]:
        names = linked(*given)
        shutil.rmtree(root / "incoming")
        return names

    linked = backup._linked
    monkeypatch.setattr(backup, "_linked", emptied)
    with pytest.raises(StorageError, match="service was started"):
        back_up(tmp_path / "data", tmp_path / "kept.tar")
    assert not (tmp_path / "kept.tar").exists()


def test_errors_name_their_own_file(tmp_path: Path) -> None:
    small_library(tmp_path / "data")
    command = [*GRIDBLOOM, "backup", str(tmp_path / "missing" / "kept.tar"), "--data-dir", str(tmp_path / "data")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert (done.returncode, "No such file" in done.stderr) == (2, True)
    (tmp_path / "file").touch()
    command = [*GRIDBLOOM, "restore", str(tmp_path / "kept.tar"), "--data-dir", str(tmp_path / "file")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert done.stderr == f"gridbloom: {tmp_path / 'file'}: File exists.\n"


def test_looking_at_the_revision_changes_neither_records_nor_journal(tmp_path: Path) -> None:
    folder = tmp_path / "killed"
    folder.mkdir()
    with contextlib.closing(sqlite3.connect(tmp_path / "library.db")) as records:
        records.execute("PRAGMA journal_mode=WAL")
        records.execute("CREATE TABLE alembic_version (version_num)")
        with records:
            records.execute("INSERT INTO alembic_version VALUES ('9999')")
        for name in ("library.db", "library.db-wal"):
            shutil.copy(tmp_path / name, folder)
    before = contents(folder)
    assert (folder / "library.db-wal").stat().st_size > 0
    with pytest.raises(StorageError, match="9999"):  # it is in the journal only
        refuse_newer_file(folder / "library.db")
    after = contents(folder)
    assert after.pop("library.db-shm")
    assert after == before


def test_an_older_service_on_a_newer_folder_says_so_and_touches_nothing(tmp_path: Path) -> None:
    folder = tmp_path / "data"
    with serving(folder) as visitor:
        uploaded(visitor, "kept.log", 5)
    with contextlib.closing(sqlite3.connect(folder / "library" / "library.db")) as records, records:
        records.execute("UPDATE alembic_version SET version_num = '9999'")
        records.execute("PRAGMA journal_mode=DELETE")
    before = contents(folder)
    for options in ((), ("--workers", "2")):
        command = [*GRIDBLOOM, "serve", "--port", "0", "--data-dir", str(folder), *options]
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        assert done.returncode == 1
        assert "newer Gridbloom" in done.stderr
        assert "9999" in done.stderr
        assert HEAD in done.stderr
        assert contents(folder) == before
    back_up(folder, tmp_path / "newer.tar")
    refused("library.newer", tmp_path / "newer.tar", tmp_path / "new")
    assert not list((tmp_path / "new").iterdir())
