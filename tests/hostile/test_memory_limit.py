"""The service at its limit of memory, as ``ulimit -v`` sets it: it refuses uploads with a sentence and goes on."""

from __future__ import annotations

import mmap
import resource
import signal
import subprocess
from pathlib import Path

import httpx
import pytest

from server.library.logs.sample import SAMPLE_ID
from server.work.memory import LEAST_BYTES
from tests.hostile.test_crash import opens, put, served, settled, uploads
from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, until

pytestmark = pytest.mark.skipif(not hasattr(resource, "prlimit"), reason="limits of another process are Linux's")


def size_of(process: subprocess.Popen[str]) -> int:
    """Return the address space of a process, bytes."""
    return int(Path(f"/proc/{process.pid}/statm").read_text().split()[0]) * mmap.PAGESIZE


def limit_to(process: subprocess.Popen[str], most: int) -> None:
    resource.prlimit(process.pid, resource.RLIMIT_AS, (most, resource.RLIM_INFINITY))


def refused(answer: httpx.Response) -> bool:
    if answer.status_code != 503:
        return False
    assert answer.json()["code"] == "service.memory"
    assert answer.json()["message"] == "The service has no memory left for this now."
    assert answer.headers["retry-after"] == "30"
    return True


@pytest.mark.long  # what fails first at the limit differs from run to run
def test_at_its_limit_of_memory_the_service_refuses_uploads_and_ends_in_order(tmp_path: Path) -> None:
    long = carmen(6000)  # more than is received in one piece
    with served(tmp_path) as (process, client):
        until(lambda: client.get(f"/api/logs/{SAMPLE_ID}").json()["state"] == "ready")
        assert put(client, "first", carmen(50)).status_code == 202
        assert settled(client, "first")["state"] == "ready"
        assert opens(client, "first")
        most = size_of(process)
        limit_to(process, most)
        until(lambda: size_of(process) <= most - LEAST_BYTES)  # it gives up its reserve
        for n in range(8):
            assert refused(put(client, f"refused {n}", long))
        assert refused(client.post("/api/sessions", json={"kind": "simulation", "world": "room", "seed": 3}))
        assert client.get("/livez").status_code == 200
        assert set(uploads(client)) == {"first"}

        limit_to(process, resource.RLIM_INFINITY)
        assert put(client, "second", long).status_code == 202
        assert settled(client, "second")["state"] == "ready"
        assert opens(client, "second")

        most = size_of(process)
        limit_to(process, most)
        until(lambda: size_of(process) <= most - LEAST_BYTES)
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE_S) == 0
