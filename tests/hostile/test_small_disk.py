"""The service on a file system that is really full: it says so, keeps what it has, and goes on when there is room."""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from sqlalchemy import delete, insert

from server.library.store.database import Database
from server.library.store.tables import ended_sign_ins as table
from server.storage import StorageError
from tests.hostile.test_crash import opens, put, served, settled, uploads
from tests.programs import in_ci
from tests.server.library.small_logs import carmen
from tests.tmpfs import tmpfs

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="it mounts a tmpfs of Linux"),
]


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 4 MB."""
    folder = tmp_path / "small"
    folder.mkdir()
    with contextlib.ExitStack() as stack:
        try:
            stack.enter_context(tmpfs(folder, "4m"))
        except PermissionError as error:
            (pytest.fail if in_ci() else pytest.skip)(str(error))
        yield folder


def fill(folder: Path) -> None:
    """Write a file into ``folder`` until its file system is full."""
    with (folder / "filler").open("wb", buffering=0) as filler:
        for size in (1 << 16, 1 << 12):
            with contextlib.suppress(OSError):
                while True:
                    filler.write(bytes(size))


def test_a_full_file_system_refuses_uploads_and_loses_none(small_disk: Path) -> None:
    logs = {f"log {n}": carmen(6000, start=n) for n in range(40)}  # 400 kB each
    with served(small_disk) as (_, client):
        assert put(client, "first", carmen(50)).status_code == 202
        assert settled(client, "first")["state"] == "ready"
        stored = []
        for name, data in logs.items():
            answer = put(client, name, data)
            if answer.status_code != 202:
                assert (answer.status_code, answer.json()["code"]) == (507, "log.storage")
                break
            stored.append(name)
        assert 1 <= len(stored) < len(logs)
        room = os.statvfs(small_disk)
        assert room.f_bavail * room.f_frsize < len(logs["log 0"]), "the disk is full, not a quota"
        assert set(uploads(client)) == {"first", *stored}
        assert opens(client, "first")
        assert client.get("/livez").status_code == 200
        for name in stored:  # a log whose arrays found no room may have failed; its bytes are there
            settled(client, name)
            assert client.delete(f"/api/logs/{uploads(client)[name]['id']}").status_code == 204
        assert put(client, "last", logs["log 0"]).status_code == 202
        assert settled(client, "last")["state"] == "ready"
    with served(small_disk) as (_, client):
        assert {name: settled(client, name)["state"] for name in uploads(client)} == {"first": "ready", "last": "ready"}
        assert opens(client, "last")


def test_any_number_of_deletions_has_room_on_a_full_disk(small_disk: Path) -> None:
    """Though others write meanwhile: what a deletion adds to SQLite's write-ahead log is given back."""
    rows = [{"name": f"{n} {'x' * 100}", "given_s": 1} for n in range(200)]
    database = Database.open(None, small_disk)
    try:
        for row in rows:
            database.now(lambda connection: connection.execute(insert(table).values(row)).rowcount)  # noqa: B023 (ends in it)
        fill(small_disk)

        async def delete_all() -> None:
            for row in rows:
                gone = delete(table).where(table.c.name == row["name"])
                await database.run_deletion(lambda connection: connection.execute(gone).rowcount)  # noqa: B023 (ends in it)
                with contextlib.suppress(StorageError):
                    await database.run(lambda connection: connection.execute(insert(table).values(row)).rowcount)  # noqa: B023

        asyncio.run(delete_all())
        assert os.statvfs(small_disk).f_bavail <= 1
    finally:
        database.close()


def test_logs_that_failed_to_read_can_be_deleted_on_a_full_disk(small_disk: Path) -> None:
    """They have no files of their own that could make room for the deletion."""
    with served(small_disk) as (_, client):
        for n in range(3):
            assert put(client, f"bad {n}", bytes([n]) * 300_000).status_code == 202
            assert settled(client, f"bad {n}")["state"] == "failed"
        fill(small_disk)
        room = os.statvfs(small_disk)
        assert room.f_bavail == 0
        for n in range(3):
            assert client.delete(f"/api/logs/{uploads(client)[f'bad {n}']['id']}").status_code == 204
        assert uploads(client) == {}
        assert os.statvfs(small_disk).f_bavail * room.f_frsize >= 600_000
