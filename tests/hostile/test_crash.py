"""The whole service on a full disk, and killed during a write: stored logs open, and no partial file is visible."""

from __future__ import annotations

import os
import re
import resource
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, until

ROOT = Path(__file__).parents[2]
SERVE = [sys.executable, "-c", "from server.cli import main; main()", "serve", "--port", "0", "--data-dir"]
#: What a process of multiprocessing says whose parent was killed before it had told it what to do.
_ORPHAN = re.compile(
    r'Traceback \(most recent call last\):\n  File "<string>", line 1, in <module>\n(?:  .*\n)+'
    r"EOFError: Ran out of input\n"
)
KEY = "an-upload-with-a-key"
WHO = {"Cookie": "gridbloom_visitor=" + "v" * 24}
LONG = carmen(500) * 120
OTHER = carmen(400) * 100
LATE = carmen(300) * 150
QUEUED = {f"queued {n}": carmen(10 + n) for n in range(6)}


@contextmanager
def served(folder: Path) -> Iterator[tuple[subprocess.Popen[str], httpx.Client]]:
    """The command, in a process that may be killed, and a visitor who is the same after a restart."""
    process = subprocess.Popen(
        [*SERVE, str(folder)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # Python does not notice that a file of bytecode was written in part, and later imports would fail.
        env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"},
    )
    try:
        assert process.stdout is not None
        found = re.search(r"http://127\.0\.0\.1:\d+", process.stdout.readline())
        assert found
        with httpx.Client(base_url=found[0], headers=WHO, timeout=PATIENCE_S) as client:
            # The address is told when the port is bound; what an earlier run left is swept before the first answer.
            assert client.get("/livez").status_code == 200
            yield process, client
    finally:
        process.kill()
        _, errors = process.communicate(timeout=PATIENCE_S)
    assert "Traceback" not in _ORPHAN.sub("", errors)


def uploads(client: httpx.Client) -> dict[str, dict[str, Any]]:
    return {log["name"]: log for log in client.get("/api/logs").json()["logs"] if log["source"] == "upload"}


def put(client: httpx.Client, name: str, data: bytes) -> httpx.Response:
    return client.put("/api/logs", params={"name": name}, content=data)


def settled(client: httpx.Client, name: str) -> dict[str, Any]:
    return dict(until(lambda: (log := uploads(client)[name])["state"] not in ("queued", "reading") and log))


def opens(client: httpx.Client, name: str) -> bool:
    answer = client.post("/api/sessions", json={"kind": "log", "log": uploads(client)[name]["id"]})
    assert answer.status_code == 201, answer.text
    return client.delete(f"/api/sessions/{answer.json()['id']}").status_code == 204


def files(folder: Path) -> dict[str, int]:
    """Number of files of each kind."""
    return {kind: len(list((folder / "library" / kind).iterdir())) for kind in ("blobs", "packs", "incoming")}


def fill_the_disk(process: subprocess.Popen[str], client: httpx.Client, folder: Path) -> None:
    """Limit the size of the service's files; return what it answers and keeps."""
    before, there = files(folder), set(uploads(client))
    unlimited = resource.prlimit(process.pid, resource.RLIMIT_FSIZE)
    for most in (0, 10_000, 300_000, 1 << 20, 2 << 20):
        resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (most, unlimited[1]))
        refused = put(client, "new", OTHER)
        assert (refused.status_code, refused.json()["code"]) == (507, "log.storage"), most
        assert client.get("/livez").status_code == 200
        assert set(uploads(client)) == there
        until(lambda: files(folder) == before)  # obstore removes its part soon after
        assert opens(client, "old")
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, unlimited)
    assert put(client, "new", OTHER).status_code == 202
    assert settled(client, "new")["state"] == "ready"
    assert opens(client, "new")


def keep_a_log(client: httpx.Client) -> None:
    assert put(client, "old", carmen(5)).status_code == 202
    assert settled(client, "old")["state"] == "ready"


def kill_in_the_middle_of_a_reading(process: subprocess.Popen[str], client: httpx.Client) -> None:
    """Kill it with more logs queued behind the one that it reads."""
    assert put(client, "long", LONG).status_code == 202
    for name, data in QUEUED.items():
        assert put(client, name, data).status_code == 202
    until(lambda: uploads(client)["long"]["state"] != "queued")
    process.send_signal(signal.SIGKILL)
    process.wait(PATIENCE_S)


def all_is_read(client: httpx.Client) -> None:
    """Everything that was acknowledged is read without being asked for."""
    assert opens(client, "old")
    assert {name: settled(client, name)["state"] for name in uploads(client)} == dict.fromkeys(
        ["old", "long", *QUEUED], "ready"
    )
    assert uploads(client)["long"]["scans"] == 60_000
    assert opens(client, "long")


def test_a_service_that_is_killed_while_it_reads(tmp_path: Path) -> None:
    with served(tmp_path) as (process, client):
        keep_a_log(client)
        kill_in_the_middle_of_a_reading(process, client)
    with served(tmp_path) as (_, client):
        all_is_read(client)


@pytest.mark.long
def test_a_service_that_is_killed_twice_and_then_has_no_disk(tmp_path: Path) -> None:
    with served(tmp_path) as (process, client):
        keep_a_log(client)
        # In the middle of an upload.
        with socket.create_connection((client.base_url.host, client.base_url.port or 0)) as half:
            head = f"PUT /api/logs?name=half&upload={KEY} HTTP/1.1\r\nHost: 127.0.0.1:{client.base_url.port}\r\n"
            head += f"Cookie: {WHO['Cookie']}\r\nContent-Range: bytes 0-{len(LONG) - 1}/{len(LONG)}\r\n"
            half.sendall(f"{head}Content-Length: {len(LONG)}\r\n\r\n".encode() + LONG[: len(LONG) // 2])
            until(lambda: files(tmp_path)["incoming"])
            process.kill()
            process.wait(PATIENCE_S)
    with served(tmp_path) as (process, client):
        assert files(tmp_path) == {"blobs": 1, "packs": 1, "incoming": 0}
        assert set(uploads(client)) == {"old"}
        assert opens(client, "old")
        assert client.get(f"/api/logs/uploads/{KEY}").json() == {"offset": 0}, "it is sent again"
        kill_in_the_middle_of_a_reading(process, client)
    with served(tmp_path) as (process, client):
        all_is_read(client)
        # Every process of the service is asked to stop, as a service manager does.
        assert put(client, "late", LATE).status_code == 202
        until(lambda: (late := uploads(client)["late"])["progress"] > 0.0 or late["state"] == "ready")
        os.killpg(process.pid, signal.SIGTERM)
        process.wait(PATIENCE_S)
    with served(tmp_path) as (process, client):
        assert settled(client, "late")["state"] == "ready"
        if hasattr(resource, "prlimit"):  # on Linux one process can limit another's files
            fill_the_disk(process, client, tmp_path)
