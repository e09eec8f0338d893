"""``/api/logs`` with requests of browsers, hostile ones among them."""

from __future__ import annotations

import gzip
import socket
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, Service, once_read, running, settings_for, until


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("library")


@pytest.fixture(scope="module")
def service(folder: Path) -> Iterator[Service]:
    shared = folder / "shared"
    shared.mkdir()
    (shared / "lecture.log").write_bytes(carmen(12))
    with running(settings_for(folder / "data", max_upload_bytes=2_000_000, logs_dir=shared)) as service:
        yield service


@pytest.fixture
def visitor(service: Service) -> Iterator[Callable[[], httpx.Client]]:
    """Makes browsers, each with a cookie jar of its own."""
    made: list[httpx.Client] = []

    def new() -> httpx.Client:
        client = httpx.Client(base_url=f"http://127.0.0.1:{service.port}", timeout=PATIENCE_S)
        client.get("/api/logs")  # the first answer brings the cookie
        made.append(client)
        return client

    yield new
    for client in made:
        client.close()


def put(client: httpx.Client, data: bytes, name: str = "run.log") -> dict[str, Any]:
    answer = client.put("/api/logs", params={"name": name}, content=data)
    assert answer.status_code == 202, answer.text
    assert answer.headers["location"] == f"/api/logs/{answer.json()['id']}"
    return dict(answer.json())


def refused(answer: httpx.Response, status: int) -> str:
    """Check an error's shape and return its code."""
    assert answer.status_code == status, answer.text
    assert set(answer.json()) == {"code", "message", "detail"}
    return str(answer.json()["code"])


def unfinished(folder: Path) -> list[Path]:
    return list((folder / "data" / "library" / "incoming").iterdir())


def test_upload_look_open_delete(visitor: Callable[[], httpx.Client]) -> None:
    client = visitor()
    log_id = put(client, gzip.compress(carmen(9)), "../../tmp/Café run.log.gz")["id"]
    log = once_read(client, log_id)
    assert (log["state"], log["name"], log["source"]) == ("ready", "Café run.log.gz", "upload")
    assert (log["scans"], log["beams"], log["duration_s"]) == (9, 3, 8.0)
    listed = client.get("/api/logs").json()["logs"]
    assert [(entry["source"], entry["name"]) for entry in listed] == [
        ("upload", "Café run.log.gz"),
        ("folder", "lecture.log"),
        ("sample", "A simulated office (sample)"),
    ]
    session = client.post("/api/sessions", json={"kind": "log", "log": log_id})
    assert session.status_code == 201, session.text
    assert client.delete(f"/api/logs/{log_id}").status_code == 204
    assert refused(client.get(f"/api/logs/{log_id}"), 404) == "log.not_found"
    # The session has the log and goes on.
    assert client.get(f"/api/sessions/{session.json()['id']}").status_code == 200


def test_another_visitors_log_is_not_there(visitor: Callable[[], httpx.Client]) -> None:
    ann, bob = visitor(), visitor()
    log_id = put(ann, carmen(4))["id"]
    once_read(ann, log_id)
    assert refused(bob.get(f"/api/logs/{log_id}"), 404) == "log.not_found"
    assert refused(bob.delete(f"/api/logs/{log_id}"), 404) == "log.not_found"
    assert refused(bob.post("/api/sessions", json={"kind": "log", "log": log_id}), 404) == "log.not_found"
    assert log_id not in bob.get("/api/logs").text
    assert once_read(ann, log_id)["state"] == "ready"


def test_the_servers_own_logs_open_for_everybody_and_stay(visitor: Callable[[], httpx.Client], folder: Path) -> None:
    client = visitor()
    own = [entry for entry in client.get("/api/logs").json()["logs"] if entry["source"] != "upload"]
    assert [entry["name"] for entry in own] == ["lecture.log", "A simulated office (sample)"]
    for entry in own:
        assert client.post("/api/sessions", json={"kind": "log", "log": entry["id"]}).status_code == 201
        facts = once_read(client, entry["id"])
        assert facts["scans"] > 0
        assert facts["trajectories"][0]["length_m"] > 0.0
        assert refused(client.delete(f"/api/logs/{entry['id']}"), 403) == "log.read_only"
    assert str(folder) not in client.get("/api/logs").text
    assert (folder / "shared" / "lecture.log").exists()


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (bytes(range(256)) * 40, "log.binary"),
        (gzip.compress(carmen(400))[:20], "log.truncated"),
        (b"# nothing\n", "log.no_scans"),
        (carmen(3) + b"FLASER 3 1.0 2.0\n" + carmen(1), None),
    ],
    ids=["garbage", "truncated gzip", "no scans", "short line"],
)
def test_bad_logs_have_their_reason(
    visitor: Callable[[], httpx.Client], folder: Path, data: bytes, code: str | None
) -> None:
    client = visitor()
    log = once_read(client, put(client, data, "bad.log")["id"])
    assert log["state"] == "failed"
    assert code is None or log["error"]["code"] == code
    assert str(folder) not in log["error"]["message"]
    assert log["id"] not in log["error"]["message"]
    opened = client.post("/api/sessions", json={"kind": "log", "log": log["id"]})
    assert refused(opened, 422) == log["error"]["code"]
    assert client.get("/livez").status_code == 200


def test_too_large_is_refused_before_it_is_sent(service: Service, folder: Path) -> None:
    with socket.create_connection(("127.0.0.1", service.port), timeout=PATIENCE_S) as raw:
        raw.sendall(
            f"PUT /api/logs?name=x HTTP/1.1\r\nHost: 127.0.0.1:{service.port}\r\n"
            f"Content-Length: {2 << 30}\r\n\r\n".encode()
        )
        answer = b""
        while not (b"log.too_large" in answer and b"setting GRIDBLOOM_MAX_UPLOAD_BYTES" in answer):
            piece = raw.recv(65536)
            assert piece, answer
            answer += piece
    assert answer.startswith(b"HTTP/1.1 413")
    assert unfinished(folder) == []


def test_too_large_without_a_length_is_cut(visitor: Callable[[], httpx.Client], folder: Path) -> None:
    client = visitor()

    def endless() -> Iterator[bytes]:
        for _ in range(40):
            yield b"x" * 100_000

    try:
        answer = client.put("/api/logs", params={"name": "x"}, content=endless())
    except httpx.WriteError:  # the server had answered and closed before all was sent
        pass
    else:
        assert refused(answer, 413) == "log.too_large"
    assert unfinished(folder) == []


def test_a_browser_that_leaves_half_way_leaves_nothing(service: Service, folder: Path) -> None:
    for _ in range(3):
        with socket.create_connection(("127.0.0.1", service.port), timeout=PATIENCE_S) as raw:
            raw.sendall(
                f"PUT /api/logs?name=half HTTP/1.1\r\nHost: 127.0.0.1:{service.port}\r\n"
                f"Content-Length: 1900000\r\n\r\n".encode()
                + b"x" * 1_800_000
            )
            until(lambda: unfinished(folder))
    until(lambda: not unfinished(folder))
    assert not [r for r in service.state.library._catalogue.all() if r.name == "half"]


def test_two_uploads_at_once(visitor: Callable[[], httpx.Client]) -> None:
    client = visitor()
    with ThreadPoolExecutor(4) as pool:
        logs = list(pool.map(lambda n: put(client, carmen(n), f"{n}.log"), (300, 400, 500, 600)))
    assert [once_read(client, log["id"])["scans"] for log in logs] == [300, 400, 500, 600]


def test_odd_requests(visitor: Callable[[], httpx.Client]) -> None:
    client = visitor()
    assert refused(client.put("/api/logs?name=x", content=b""), 422) == "log.empty"
    assert refused(client.put("/api/logs", params={"name": "n" * 2000}, content=b"x"), 422) == "request.invalid"
    for log_id in ("nope", "%2e%2e%2frecords", "..%5c..", "a" * 5000):
        assert client.get(f"/api/logs/{log_id}").status_code == 404
    other = client.put("/api/logs?name=x", content=b"x", headers={"Origin": "http://evil.example"})
    assert refused(other, 403) == "security.origin"


def test_a_reading_is_stopped_and_run_again(visitor: Callable[[], httpx.Client]) -> None:
    ann, ben = visitor(), visitor()
    log = put(ann, carmen(20_000), "long.log")
    address = f"/api/logs/{log['id']}"
    stopped = ann.post(f"{address}/cancel").json()
    if stopped["state"] == "failed":  # not read already
        assert stopped["error"]["code"] == "log.cancelled"
    for what in ("cancel", "read"):
        assert refused(ben.post(f"{address}/{what}"), 404) == "log.not_found"
        assert refused(ann.post(f"/api/logs/sample-office/{what}"), 403) == "log.read_only"
    answer = ann.post(f"{address}/read")
    assert answer.status_code == 202
    assert once_read(ann, log["id"])["state"] == "ready"
    ann.delete(address)
