"""Uploads in parts that are cut at each tenth, sent by a client that disconnects."""

from __future__ import annotations

import hashlib
import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from server.library.uploads import receiver as intake
from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, Service, once_read, running, settings_for, until

DATA = carmen(3000)
KEY = "k" * 20


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("parts")


@pytest.fixture(scope="module")
def service(folder: Path) -> Iterator[Service]:
    with running(settings_for(folder, max_upload_bytes=2_000_000)) as service:
        yield service


@pytest.fixture
def client(service: Service) -> Iterator[httpx.Client]:
    with httpx.Client(base_url=f"http://127.0.0.1:{service.port}", timeout=PATIENCE_S) as client:
        client.get("/api/logs")
        yield client
        for log in client.get("/api/logs").json()["logs"]:
            client.delete(f"/api/logs/{log['id']}")


def part(
    client: httpx.Client, first: int, last: int, total: int = len(DATA), key: str = KEY, **params: Any
) -> httpx.Response:
    return client.put(
        "/api/logs",
        params={"name": "run.log", "upload": key} | params,
        content=DATA[first : last + 1],
        headers={"Content-Range": f"bytes {first}-{last}/{total}"},
    )


def offset(client: httpx.Client, key: str = KEY) -> int:
    return int(client.get(f"/api/logs/uploads/{key}").json()["offset"])


def test_an_upload_that_is_given_up_is_removed(client: httpx.Client, folder: Path) -> None:
    assert part(client, 0, 999).status_code == 200
    assert offset(client) == 1000
    assert client.delete(f"/api/logs/uploads/{KEY}").status_code == 204
    assert offset(client) == 0
    until(lambda: incoming(folder) == [])
    assert client.delete(f"/api/logs/uploads/{KEY}").status_code == 204  # there is none any more


def test_an_upload_that_is_given_up_while_it_comes_in_is_removed_at_its_end(
    service: Service, client: httpx.Client, folder: Path
) -> None:
    cookies = "; ".join(f"{name}={value}" for name, value in client.cookies.items())
    with socket.create_connection(("127.0.0.1", service.port)) as line:
        line.sendall(
            f"PUT /api/logs?name=a&upload={KEY} HTTP/1.1\r\nHost: 127.0.0.1:{service.port}\r\nCookie: {cookies}\r\n"
            f"Content-Length: {len(DATA)}\r\nContent-Range: bytes 0-{len(DATA) - 1}/{len(DATA)}\r\n\r\n".encode()
        )
        line.sendall(DATA[:1000])
        until(lambda: [one.busy for one in service.state.library._intake._partial.values()] == [True])
        assert client.delete(f"/api/logs/uploads/{KEY}").status_code == 204
    until(lambda: incoming(folder) == [])
    until(lambda: offset(client) == 0)


def incoming(folder: Path) -> list[Path]:
    return list((folder / "library" / "incoming").iterdir())


def test_in_ten_parts(client: httpx.Client, folder: Path) -> None:
    step = -(-len(DATA) // 10)
    for first in range(0, len(DATA), step):
        last = min(first + step, len(DATA)) - 1
        assert offset(client) == first
        answer = part(client, first, last)
        if last + 1 < len(DATA):
            assert (answer.status_code, answer.json()) == (200, {"offset": last + 1, "total": len(DATA)})
    assert answer.status_code == 202
    log = once_read(client, answer.json()["id"])
    assert (log["state"], log["scans"], log["bytes"]) == ("ready", 3000, len(DATA))
    assert (folder / "library" / "blobs" / hashlib.sha256(DATA).hexdigest()).read_bytes() == DATA
    assert incoming(folder) == []


@pytest.mark.parametrize("tenth", range(11))
def test_an_upload_cut_at_a_tenth_is_resumed(service: Service, client: httpx.Client, folder: Path, tenth: int) -> None:
    sent = len(DATA) * tenth // 10
    cookie = f"gridbloom_visitor={client.cookies['gridbloom_visitor']}"
    head = (
        f"PUT /api/logs?name=run.log&upload={KEY} HTTP/1.1\r\nHost: 127.0.0.1:{service.port}\r\nCookie: {cookie}\r\n"
        f"Content-Length: {len(DATA)}\r\nContent-Range: bytes 0-{len(DATA) - 1}/{len(DATA)}\r\n\r\n"
    )
    with socket.create_connection(("127.0.0.1", service.port)) as raw:
        raw.sendall(head.encode() + DATA[:sent])
        if tenth == 10:
            assert raw.recv(12) == b"HTTP/1.1 202"
    expected = 0 if tenth == 10 else sent
    until(lambda: offset(client) == expected)
    if tenth < 10:
        # The connection may still be known as busy for a moment.
        answer = until(lambda: (found := part(client, expected, len(DATA) - 1)).status_code != 409 and found)
        assert answer.status_code == 202
        log = once_read(client, answer.json()["id"])
    else:
        log = once_read(client, client.get("/api/logs").json()["logs"][0]["id"])
    assert (log["scans"], log["bytes"]) == (3000, len(DATA))
    assert incoming(folder) == []


def test_the_same_file_twice_is_stored_once(client: httpx.Client) -> None:
    first = part(client, 0, len(DATA) - 1).json()["id"]
    assert part(client, 0, 999, key="another-key-of-mine").status_code == 200
    assert part(client, 1000, len(DATA) - 1, key="another-key-of-mine").json()["id"] == first
    assert client.put("/api/logs", content=DATA).json()["id"] == first


def test_a_part_with_a_wrong_offset_is_refused_and_offset_0_begins_again(client: httpx.Client) -> None:
    assert part(client, 0, 999).status_code == 200
    wrong = part(client, 2000, 2999)
    assert (wrong.status_code, wrong.json()["code"]) == (409, "upload.offset")
    assert "has 1000 bytes" in wrong.json()["message"]
    assert offset(client) == 1000
    assert part(client, 0, 499).json()["offset"] == 500
    assert part(client, 500, len(DATA) - 1).status_code == 202


def test_another_visitor_does_not_see_it(service: Service, client: httpx.Client) -> None:
    part(client, 0, 999)
    with httpx.Client(base_url=f"http://127.0.0.1:{service.port}") as other:
        assert offset(other) == 0
        assert part(other, 1000, 1999).json()["code"] == "upload.offset"
    part(client, 1000, len(DATA) - 1)


@pytest.mark.parametrize(
    ("headers", "code"),
    [
        ({}, "upload.range"),
        ({"Content-Range": "bytes 5-4/100"}, "upload.range"),
        ({"Content-Range": "bytes 0-100/100"}, "upload.range"),
        ({"Content-Range": "bytes 0-9/*"}, "upload.range"),
        ({"Content-Range": "bytes 0-9/9999999999999999"}, "upload.range"),
        ({"Content-Range": "bytes 0-9/3000000"}, "log.too_large"),
        ({"Content-Range": "bytes 0-9/500"}, "upload.length"),
    ],
)
def test_ranges_that_make_no_sense(client: httpx.Client, folder: Path, headers: dict[str, str], code: str) -> None:
    answer = client.put("/api/logs", params={"upload": KEY}, content=DATA[:1000], headers=headers)
    assert answer.status_code in (413, 422)
    assert answer.json()["code"] == code
    assert incoming(folder) == []


@pytest.mark.parametrize("key", ["short", "x" * 65, "../../../../etc/passwd", "a" * 15 + "%00"])
def test_keys_that_are_none(client: httpx.Client, key: str) -> None:
    assert part(client, 0, 9, key=key).status_code == 422
    assert client.get(f"/api/logs/uploads/{key}").status_code in (404, 422)


def test_a_digest_that_is_not_the_logs(client: httpx.Client, folder: Path) -> None:
    wrong = part(client, 0, len(DATA) - 1, sha256="0" * 64)
    assert (wrong.status_code, wrong.json()["code"]) == (422, "upload.digest")
    assert incoming(folder) == []
    assert part(client, 0, len(DATA) - 1, sha256=hashlib.sha256(DATA).hexdigest()).status_code == 202


def test_cut_uploads_are_few_and_leave_in_time(
    service: Service, client: httpx.Client, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    keys = [f"upload-number-{i:04d}" for i in range(intake.MAX_PARTIALS_PER_OWNER + 2)]
    for key in keys:
        assert part(client, 0, 99, key=key).status_code == 200
    assert [offset(client, key) for key in keys] == [0, 0] + [100] * intake.MAX_PARTIALS_PER_OWNER
    monkeypatch.setattr(intake, "KEEP_PARTIAL_S", 0.0)
    assert offset(client, keys[-1]) == 0
    assert incoming(folder) == []


def test_a_restart_forgets_cut_uploads(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.library.store.blobs.LOCAL_PART_BYTES", 100)  # what is held in memory leaves no file
    new: Callable[[], Any] = lambda: running(settings_for(tmp_path))  # noqa: E731
    with new() as first:
        assert part(first.http, 0, 999).json()["offset"] == 1000
        assert len(incoming(tmp_path)) == 1
    assert incoming(tmp_path) == []
    with new() as second:
        assert offset(second.http) == 0
