"""Two stores of logs never share the records of one: the second is refused, and the records stay."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from obstore.store import MemoryStore
from pydantic import SecretStr
from sqlalchemy import text

from server.library.library import Library
from server.library.store.blobs import Blobs
from server.library.store.database import Database
from server.library.store.identity import check_store_identity
from server.library.store_check import check_stores
from server.settings import Settings
from server.storage import StorageError
from tests.server.library.postgresql import Cluster
from tests.server.library.small_logs import carmen, in_pieces


@pytest.fixture(params=["sqlite", "postgresql"])
def url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'records.db'}"
    return str(request.getfixturevalue("postgresql").new_database())


def forget(url: str, folder: Path) -> None:
    database = Database.open(url, folder)
    database.now(lambda connection: connection.execute(text("DELETE FROM store")))
    database.close()


def test_a_second_data_folder_on_the_same_database_is_refused(url: str, tmp_path: Path) -> None:
    first = Settings(data_dir=tmp_path / "first", database=SecretStr(url))
    second = Settings(data_dir=tmp_path / "second", database=SecretStr(url))
    check_stores(first)
    check_stores(first)
    with pytest.raises(StorageError, match="belongs to the logs of another data folder or bucket") as caught:
        check_stores(second)
    assert caught.value.code == "library.another_store"
    # A folder that has moved is the same one; and a database that knows of none takes the next.
    (tmp_path / "first").rename(tmp_path / "moved")
    check_stores(Settings(data_dir=tmp_path / "moved", database=SecretStr(url)))
    forget(url, tmp_path)
    check_stores(second)
    forget(url, tmp_path)


def test_records_of_another_bucket_are_refused(tmp_path: Path) -> None:
    bucket, other = Blobs(MemoryStore(), None, tmp_path), Blobs(MemoryStore(), None, tmp_path)
    database = Database.open(None, tmp_path)
    check_store_identity(database, bucket)
    check_store_identity(database, bucket)
    with pytest.raises(StorageError, match="another data folder or bucket"):
        check_store_identity(database, other)
    database.close()


def test_an_unreachable_store_is_accepted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A bucket that does not answer for a moment keeps no service from starting."""
    monkeypatch.setattr("server.library.store.blobs.RETRY", {"max_retries": 0})
    monkeypatch.setenv("AWS_ENDPOINT", "http://127.0.0.1:1")
    for name in ("AWS_ALLOW_HTTP", "AWS_SKIP_SIGNATURE"):
        monkeypatch.setenv(name, "true")
    database = Database.open(None, tmp_path)
    check_store_identity(database, Blobs.at("s3://a-bucket/logs", tmp_path))
    database.close()


@pytest.mark.parametrize("names", [set(), {"f" * 64}])
async def test_nothing_is_deleted_while_the_stores_identity_is_unknown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, names: set[str]
) -> None:
    """It was away when it was asked, and is another bucket than the one that the records know."""
    settings = Settings(data_dir=tmp_path)
    check_stores(settings)
    library = Library(settings)
    await library.start()
    record = await library.put("ann", "a.log", in_pieces(carmen(5)))
    await library.close()

    def away(_: Blobs) -> str:
        raise StorageError("log.store", "The server cannot reach its store of logs just now.")

    async def another(_: Blobs) -> set[str]:
        return names

    deleted: list[str] = []
    monkeypatch.setattr(Blobs, "identity", away)
    monkeypatch.setattr(Blobs, "names", another)
    monkeypatch.setattr(Blobs, "delete", lambda _, name: deleted.append(name))
    library = Library(settings)
    await library.start()
    assert library.get("ann", record.id).name == "a.log"
    await library.close()
    assert deleted == []


def test_of_two_stores_that_claim_a_database_concurrently_one_is_refused(url: str, tmp_path: Path) -> None:
    databases = [Database.open(url, tmp_path) for _ in range(2)]
    stores = [Blobs(MemoryStore(), None, tmp_path) for _ in range(2)]
    together = threading.Barrier(2)

    def claim(at: int) -> bool:
        together.wait()
        try:
            check_store_identity(databases[at], stores[at])
        except StorageError:
            return False
        return True

    for _ in range(10):
        with ThreadPoolExecutor(2) as pool:
            assert sorted(pool.map(claim, range(2))) == [False, True]
        forget(url, tmp_path)
    for database in databases:
        database.close()


def test_a_new_store_gets_its_id_from_one_service_at_a_time(postgresql: Cluster, tmp_path: Path) -> None:
    """Some stores accept both of two writes that are to create a file."""
    database = Database.open(postgresql.new_database(), tmp_path)
    beside = Database.open(database.address, tmp_path)
    held = text("SELECT count(*) FROM pg_locks WHERE locktype = 'advisory' AND objid = 1196574019 AND granted")
    found: list[int] = []

    class Store(Blobs):
        def identity(self) -> str:
            found.append(beside.now(lambda connection: connection.execute(held).scalar_one()))
            return super().identity()

    check_store_identity(database, Store(MemoryStore(), None, tmp_path))
    assert found == [1]
    for one in (database, beside):
        one.close()
