"""Deletions on a full disk: in the room that is kept for them."""

from __future__ import annotations

import asyncio
import errno
import os
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import delete, event, insert, select

from server.library.store.database import RESERVE_BYTES, Database, Reserve
from server.library.store.tables import ended_sign_ins as table
from server.storage import RECORDS_FILE, StorageError


@pytest.fixture
def database(tmp_path: Path) -> Iterator[Database]:
    opened = Database.open(None, tmp_path)
    opened.now(lambda connection: connection.execute(insert(table).values(name="a", given_s=1)).rowcount)
    yield opened
    opened.close()


def names(database: Database) -> list[str]:
    return list(database.now(lambda connection: connection.execute(select(table.c.name)).scalars().all()))


def deleted(database: Database) -> None:
    async def work() -> None:
        await database.run_deletion(lambda connection: connection.execute(delete(table)).rowcount)

    asyncio.run(work())


def log_bytes(folder: Path) -> int:
    """The size of SQLite's write-ahead log."""
    return (folder / f"{RECORDS_FILE}-wal").stat().st_size


def full_while(database: Database, is_full: Any) -> None:
    """Let each change fail as on a full disk while ``is_full`` returns true."""

    def refuse(_1: object, _2: object, statement: str, *_: object) -> None:
        if statement.startswith("DELETE") and is_full():
            raise sqlite3.OperationalError("database or disk is full")

    event.listen(database._engine, "before_cursor_execute", refuse)


def test_a_deletion_on_a_full_disk_takes_the_room_that_is_kept(database: Database, tmp_path: Path) -> None:
    (reserve,) = tmp_path.glob("*-reserve")
    assert reserve.stat().st_blocks * 512 >= RESERVE_BYTES
    full_while(database, reserve.exists)
    deleted(database)
    assert names(database) == []
    assert reserve.stat().st_size == RESERVE_BYTES, "taken again, before an upload takes it"
    assert log_bytes(tmp_path) == 0, "the next deletion has as much room"


def test_the_write_ahead_log_fits_into_the_room_that_is_kept(database: Database, tmp_path: Path) -> None:
    """Emptying it makes the file grow by what is in it."""
    for n in range(500):
        database.now(lambda connection: connection.execute(insert(table).values(name=f"{n} {'x' * 500}", given_s=1)))  # noqa: B023 (ends in it)
    assert 0 < log_bytes(tmp_path) < 1.2 * RESERVE_BYTES


def test_as_much_is_kept_as_there_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    allocate, room = os.posix_fallocate, [0]

    def limited(handle: int, start: int, size: int) -> None:
        allocate(handle, start, min(size, room[0]))
        if size > room[0]:
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "posix_fallocate", limited)
    reserve, sizes = Reserve(tmp_path / "reserve"), []
    for room[0] in (10_000, 100_000, 100, 1_000_000):
        reserve.keep()
        sizes.append((tmp_path / "reserve").stat().st_size)
    assert sizes == [0, 65536, 65536, RESERVE_BYTES]


def test_the_room_is_kept_again_at_the_next_deletion(database: Database, tmp_path: Path) -> None:
    (reserve,) = tmp_path.glob("*-reserve")
    reserve.unlink()
    deleted(database)
    assert reserve.stat().st_size == RESERVE_BYTES


def test_where_even_that_is_too_little_nothing_is_deleted(database: Database) -> None:
    full_while(database, lambda: True)
    with pytest.raises(StorageError, match="full"):
        deleted(database)
    assert names(database) == ["a"]
