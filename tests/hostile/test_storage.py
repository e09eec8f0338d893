"""Data folders and databases that disappear while the service runs: it says so, and confirms no upload."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from server.library.store.known_paths import KnownPaths
from server.storage import StorageError
from tests.server.service import Service, once_read, running, settings_for


def log(number: int) -> bytes:
    """Return a small log in CARMEN's format, another one for each number."""
    lines = (f"FLASER 3 1.0 1.0 1.{number} 0 0 0 0 0 0 {i}.0 x {i}.0\n" for i in range(1, 6))
    return "".join(lines).encode()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("storage")


@pytest.fixture(scope="module")
def service(folder: Path) -> Iterator[Service]:
    with running(settings_for(folder / "data")) as service:
        once_read(service.http, put(service, 1).json()["id"])
        yield service


def put(service: Service, number: int) -> httpx.Response:
    return service.http.put("/api/logs", params={"name": f"{number}.log"}, content=log(number))


@pytest.mark.parametrize("what", ["data", "data/library", "data/library/library.db"])
def test_what_is_gone_refuses_uploads_until_it_is_back(service: Service, folder: Path, what: str) -> None:
    number = 10 + len(what)
    (folder / what).rename(folder / "away")
    for answer in (put(service, number), service.http.get("/readyz")):
        assert (answer.status_code, answer.json()["code"]) == (503, "library.gone")
    assert service.http.get("/livez").status_code == 200
    (folder / "away").rename(folder / what)
    assert service.http.get("/readyz").status_code == 200
    assert once_read(service.http, put(service, number).json()["id"])["state"] == "ready"
    records = service.http.get("/api/logs").json()["logs"]
    assert sum(record["name"] == f"{number}.log" for record in records) == 1


def test_another_folder_in_its_place_is_not_taken_for_it(service: Service, folder: Path) -> None:
    (folder / "data").rename(folder / "away")
    for name in ("library", "library/incoming"):
        (folder / "data" / name).mkdir(parents=True)
    assert put(service, 99).json()["code"] == "library.gone"
    for name in ("library/incoming", "library", "."):
        (folder / "data" / name).rmdir()
    (folder / "away").rename(folder / "data")


def test_a_folder_that_turns_read_only_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    standing = KnownPaths([tmp_path])
    standing.check()
    monkeypatch.setattr("os.access", lambda path, mode: False)
    with pytest.raises(StorageError) as refused:
        standing.check()
    assert refused.value.code == "library.read_only"
