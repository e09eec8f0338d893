"""Connections that send nothing or half a header are closed and block nobody, nor does a lack of descriptors."""

from __future__ import annotations

import contextlib
import os
import re
import resource
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import httpx
import pytest

from tests.marks import also_long
from tests.server.service import PATIENCE_S, running, settings_for, until

ROOT = Path(__file__).parents[2]
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="needs 127.0.0.2, /proc and prlimit")
HALF = b"GET /livez HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Half: "
PROGRAM = """
import resource, sys
if sys.argv[1] != "0":
    resource.setrlimit(resource.RLIMIT_NOFILE, (int(sys.argv[1]), int(sys.argv[1])))
from server.cli import main
sys.argv[1:] = ["serve", "--port", "0"]
main()
"""


class Process:
    """A service in a process of its own, whose log goes to a file."""

    def __init__(self, process: subprocess.Popen[str], port: int, log: Path) -> None:
        self.process, self.port, self._log = process, port, log

    def is_alive(self) -> bool:
        """Whether it answers a new connection."""
        return httpx.get(f"http://127.0.0.1:{self.port}/livez", timeout=PATIENCE_S).status_code == 200

    def connect(self, data: bytes = b"") -> socket.socket:
        """Open a connection and send ``data``."""
        connection = socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE_S)
        with contextlib.suppress(ConnectionError):  # closed already
            connection.sendall(data)
        return connection

    def lines(self) -> list[str]:
        return self._log.read_text().splitlines()


@contextmanager
def serving(folder: Path, descriptors: int = 0, **settings: str) -> Iterator[Process]:
    own = {f"GRIDBLOOM_{name.upper()}": value for name, value in settings.items()}
    log = folder / "log"
    with log.open("w") as errors:
        process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM, str(descriptors)],
            cwd=ROOT,
            env=os.environ | {"GRIDBLOOM_DATA_DIR": str(folder / "data"), "PYTHONPATH": str(ROOT)} | own,
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
        )
    try:
        assert process.stdout is not None
        found = re.search(r":(\d+)/", process.stdout.readline())
        assert found, log.read_text()
        service = Process(process, int(found[1]), log)
        until(service.is_alive)
        yield service
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=PATIENCE_S)
        assert process.returncode == 0
    finally:
        process.kill()
        process.communicate()


@pytest.fixture
def many_descriptors() -> Iterator[None]:
    """Let this process open 2,000 connections."""
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    if limits[1] < 3000:
        pytest.skip("this system lets a process open too few files")
    resource.setrlimit(resource.RLIMIT_NOFILE, (limits[1], limits[1]))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, limits)


def until_closed(connections: list[socket.socket], trickle: bytes = b"") -> None:
    """Wait until the other end has closed all of them; meanwhile send ``trickle`` on each now and then."""
    watched = select.poll()
    left = {connection.fileno(): connection for connection in connections}
    for descriptor in left:
        watched.register(descriptor, select.POLLIN)
    deadline = time.monotonic() + PATIENCE_S
    while left:
        assert time.monotonic() < deadline, f"{len(left)} connections are still open"
        for descriptor, _ in watched.poll(200):
            with contextlib.suppress(ConnectionError):
                assert left[descriptor].recv(1000) == b""
            watched.unregister(descriptor)
            del left[descriptor]
        for connection in left.values():
            with contextlib.suppress(ConnectionError):
                connection.send(trickle)


@pytest.mark.usefixtures("many_descriptors")
@pytest.mark.parametrize("sent", [HALF, *also_long(b"")])
def test_two_thousand_idle_connections_are_closed_and_do_not_block_others(tmp_path: Path, sent: bytes) -> None:
    with (
        serving(tmp_path, header_timeout_s="2", max_connections_per_address="3000") as service,
        ExitStack() as held,
    ):
        connections = [held.enter_context(service.connect(sent)) for _ in range(2000)]
        assert service.is_alive()
        until_closed(connections, sent[-1:])
        assert service.is_alive()
        assert "Traceback" not in "".join(service.lines())


def test_a_slow_header_after_an_answer_ends_its_connection(tmp_path: Path) -> None:
    with running(settings_for(tmp_path, header_timeout_s=0.5)) as service:
        for rest in (HALF, b"POST /api/nothing HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 100000\r\n\r\n"):
            with socket.create_connection(("127.0.0.1", service.port), timeout=PATIENCE_S) as connection:
                connection.sendall(b"GET /livez HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
                assert connection.recv(10_000).startswith(b"HTTP/1.1 200")
                connection.sendall(rest)
                with contextlib.suppress(ConnectionError):
                    deadline = time.monotonic() + PATIENCE_S
                    connection.settimeout(0.1)
                    while time.monotonic() < deadline:
                        with contextlib.suppress(TimeoutError):
                            if not connection.recv(10_000):
                                break
                        connection.send(b"x")
                assert time.monotonic() < deadline


def test_a_new_connection_replaces_the_one_idle_for_longest(tmp_path: Path) -> None:
    with running(settings_for(tmp_path, max_connections=3)) as service, ExitStack() as held:
        silent = [held.enter_context(socket.create_connection(("127.0.0.1", service.port))) for _ in range(3)]
        until(lambda: len(service.server.connections) == 3)
        assert service.http.get("/livez").status_code == 200
        until_closed(silent[:1])
        assert len(service.server.connections) == 3
        silent[2].settimeout(PATIENCE_S)
        silent[2].sendall(b"GET /livez HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        assert silent[2].recv(10_000).startswith(b"HTTP/1.1 200")


@LINUX
def test_one_address_has_its_share_and_leaves_the_others_theirs(tmp_path: Path) -> None:
    with running(settings_for(tmp_path, max_connections_per_address=3)) as service, ExitStack() as held:
        session = service.begin()
        service.http.close()
        until(lambda: len(service.server.connections) == 0)
        for _ in range(3):
            held.enter_context(streaming(service.port, session))
        with pytest.raises(httpx.TransportError):
            httpx.get(f"http://127.0.0.1:{service.port}/livez", timeout=PATIENCE_S)
        with httpx.Client(
            base_url=f"http://127.0.0.1:{service.port}",
            timeout=PATIENCE_S,
            transport=httpx.HTTPTransport(local_address="127.0.0.2"),
        ) as other:
            assert other.get("/livez").status_code == 200


@contextmanager
def streaming(port: int, session: str) -> Iterator[None]:
    """A connection that is a WebSocket."""
    with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S) as connection:
        connection.sendall(
            f"GET /api/sessions/{session}/stream HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n".encode()
            + b"Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
            + b"Sec-WebSocket-Protocol: gridbloom.v3\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
        )
        assert connection.recv(12) == b"HTTP/1.1 101"
        yield


def test_more_connections_than_descriptors_do_not_block_others(tmp_path: Path) -> None:
    with serving(tmp_path, descriptors=256) as service, ExitStack() as held:
        for _ in range(6):
            for _ in range(100):
                held.enter_context(service.connect(HALF))
            assert service.is_alive()
        assert "Traceback" not in "".join(service.lines())
        assert len(service.lines()) < 10


@LINUX
def test_a_lack_of_descriptors_is_logged_once_and_recovered_from(tmp_path: Path) -> None:
    with serving(tmp_path) as service, ExitStack() as held:
        pid = service.process.pid
        limits = resource.prlimit(pid, resource.RLIMIT_NOFILE)
        descriptors = sorted(int(path.name) for path in Path(f"/proc/{pid}/fd").iterdir())
        # As if files had taken all the others: there is none above the highest that is open.
        resource.prlimit(pid, resource.RLIMIT_NOFILE, (descriptors[-1] + 1, limits[1]))
        until_closed([held.enter_context(service.connect(HALF)) for _ in range(descriptors[-1] + 50)][-20:])
        resource.prlimit(pid, resource.RLIMIT_NOFILE, limits)
        assert service.is_alive()
        told = [line for line in service.lines() if "no descriptors are left" in line]
        assert len(told) == 1
        assert "Traceback" not in "".join(service.lines())
