"""Every port that the service listens on, while a 3D view is open, for another site's page without the token."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
import viser
from websockets.exceptions import InvalidHandshake
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin, Subprotocol

from tests.server.listening import listening_ports
from tests.server.service import PATIENCE_S

ROOT = Path(__file__).parents[2]
TOKEN = "correct-horse-battery"
VISER = Subprotocol(f"viser-v{viser.__version__}")
EVIL = "evil.example"


@pytest.fixture
def guarded(tmp_path: Path) -> Iterator[tuple[int, int]]:
    """The process id and the port of a service that asks for a token."""
    process = subprocess.Popen(
        [sys.executable, "-c", "from server.cli import main; main()", "serve", "--port", "0", "--data-dir", tmp_path],
        cwd=ROOT,
        env={"GRIDBLOOM_TOKEN": TOKEN, "PATH": "/usr/bin:/bin"},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    found = re.search(r":(\d+)/", process.stdout.readline())
    assert found
    try:
        yield process.pid, int(found[1])
    finally:
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=PATIENCE_S)


def opened(port: int, path: str, host: str, origin: str | None, protocol: str) -> ClientConnection:
    """Connect to ``port`` of this machine, as a browser does that knows it as ``host``."""
    connection = connect(
        f"ws://{host}{path}",
        sock=socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S),
        origin=None if origin is None else Origin(origin),
        subprotocols=[Subprotocol(protocol)],
        proxy=None,
        open_timeout=PATIENCE_S,
        ping_interval=None,  # on a busy machine it takes longer to close than to miss an answer
    )
    connection.close()
    return connection


def test_no_port_answers_another_sites_page_without_the_token(guarded: tuple[int, int]) -> None:
    pid, port = guarded
    headers = {"Authorization": f"Bearer {TOKEN}"}
    base = f"http://127.0.0.1:{port}"
    session_id = httpx.post(
        f"{base}/api/sessions", json={"kind": "simulation"}, headers=headers, timeout=PATIENCE_S
    ).json()["id"]
    scene = f"/scenes/{session_id}/"
    with connect(
        f"ws://127.0.0.1:{port}{scene}",
        subprotocols=[VISER],
        additional_headers=headers,
        max_size=None,
        max_queue=None,  # with a limit the answer to a ping lies behind what the test does not read
        ping_interval=None,
        proxy=None,
    ) as view:
        assert view.recv(timeout=PATIENCE_S)
        ports = listening_ports(pid)
        assert port in ports
        for one in ports:
            for host in (EVIL, f"127.0.0.1:{one}"):
                for path in ("/", "/index.html", scene, f"/api/sessions/{session_id}", "/metrics"):
                    url = f"http://127.0.0.1:{one}{path}"
                    answer = httpx.get(url, headers={"Host": host, "Origin": f"https://{EVIL}"}, timeout=PATIENCE_S)
                    assert answer.status_code in (401, 421), (one, host, path)
                    assert set(answer.json()) == {"code", "message", "detail"}
                for path in ("/", scene, f"/api/sessions/{session_id}/stream"):
                    for origin in (f"https://{EVIL}", f"http://127.0.0.1:{one}", "null", None):
                        for protocol in (VISER, "gridbloom.v3"):
                            with pytest.raises((InvalidHandshake, EOFError)):
                                opened(one, path, host, origin, protocol)
        assert ports == {port}
        view.ping().wait(PATIENCE_S)  # the view that has the token goes on
