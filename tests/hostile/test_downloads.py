"""Guests who download a large map repeatedly, and clients that read nothing: memory, answers, shutdown."""

from __future__ import annotations

import asyncio
import contextlib
import io
import os
import re
import signal
import socket
import subprocess
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import httpx
import numpy as np
import pytest
from PIL import Image

from tests.hostile.test_ending import ROOT, SERVE
from tests.marks import also_long_rows
from tests.server.service import PATIENCE_S, Watcher, eventually, stream_at, until

TOKEN = "a-secret-of-the-service"
GUESTS = 12
MAX_RSS = 1_500_000_000
MAX_OF_TWO = 2 * (64 << 20) + (16 << 20)  #: bytes of two downloads, and of all else that happens meanwhile
#: Cells of a map, and the side of the square that the robot drives over: the sensor's range comes to it on all sides.
WIDE = (30_000_000, 219.0)
LESS_WIDE = (4_000_000, 46.0)


def wide_log(side_m: float) -> str:
    """A log in CSV whose robot crosses a wide square and sees walls at all ranges."""
    rng = np.random.default_rng(4)
    lines = ["angle_min,-3.14159", f"angle_increment,{2 * np.pi / 360:.7f}", "range_min,0.05", "range_max,30"]
    lines.append("stamp,x,y,theta,ranges")
    for number, (x, y) in enumerate(np.stack(np.meshgrid(*[np.linspace(0.0, side_m, 6)] * 2), -1).reshape(-1, 2)):
        ranges = ",".join(f"{r:.2f}" for r in rng.uniform(5.0, 29.0, 360))
        lines.append(f"{number / 10:.1f},{x:.2f},{y:.2f},0.0,{ranges}")
    return "\n".join(lines)


@dataclass
class Process:
    """A service in a process of its own."""

    popen: subprocess.Popen[str]
    port: int

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def client(self, *, guest: bool = False) -> httpx.Client:
        headers = {} if guest else {"Authorization": f"Bearer {TOKEN}"}
        return httpx.Client(base_url=self.address, headers=headers, timeout=PATIENCE_S)

    def forget_peak(self) -> None:
        """Let :attr:`most_bytes` begin again with what the process holds now."""
        Path(f"/proc/{self.popen.pid}/clear_refs").write_text("5")

    @property
    def most_bytes(self) -> int:
        """The most memory that the process has held, resident."""
        found = re.search(r"VmHWM:\s*(\d+) kB", Path(f"/proc/{self.popen.pid}/status").read_text())
        assert found
        return 1024 * int(found[1])


@pytest.fixture
def side_m() -> float:
    """The side of the square; tests may have another by a parameter of this name."""
    return WIDE[1]


@pytest.fixture
def process(tmp_path: Path, side_m: float) -> Iterator[Process]:
    if not Path("/proc/self/status").exists():
        pytest.skip("the memory of another process is read from /proc")
    logs = tmp_path / "logs"
    logs.mkdir()
    (logs / "wide.csv").write_text(wide_log(side_m))
    popen = subprocess.Popen(
        [*SERVE, str(tmp_path / "data")],
        cwd=ROOT,
        env=os.environ | {"GRIDBLOOM_TOKEN": TOKEN, "GRIDBLOOM_LOGS_DIR": str(logs)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert popen.stdout is not None
        found = re.search(r":(\d+)/", popen.stdout.readline())
        assert found
        yield Process(popen, int(found[1]))
    finally:
        popen.kill()
        popen.communicate()


async def guest_session(process: Process) -> str:
    """Return a session that a guest began by a link to the whole map of the wide log."""
    with process.client() as owner, process.client(guest=True) as guest:
        log = until(lambda: next(one for one in owner.get("/api/logs").json()["logs"] if one["name"] == "wide.csv"))
        answer = owner.post("/api/sessions", json={"kind": "log", "log": log["id"], "playing": False})
        assert answer.status_code == 201, answer.text
        session = answer.json()["id"]
        stream = f"ws://127.0.0.1:{process.port}/api/sessions/{session}/stream"
        async with stream_at(stream, additional_headers={"Authorization": f"Bearer {TOKEN}"}) as connection:
            watcher = Watcher(connection)
            await watcher.send("seek", index=36)
            await watcher.until(lambda: watcher.newest.get("frame", {}).get("index") == 36)
        token = owner.post(f"/api/sessions/{session}/links", json={}).json()["token"]
        assert owner.delete(f"/api/sessions/{session}").status_code == 204
        answer = guest.post(f"/api/shared/{token}/sessions")
        assert answer.status_code == 201, answer.text
        return str(answer.json()["id"])


@pytest.mark.parametrize(("cells", "side_m"), [LESS_WIDE, *also_long_rows(WIDE)])
async def test_twelve_guests_download_a_wide_map(process: Process, cells: int) -> None:
    session = await guest_session(process)

    def take(_: int) -> httpx.Response:
        with process.client(guest=True) as guest:  # no cookie: a visitor nobody has seen
            return guest.get(f"/api/sessions/{session}/map.png")

    with process.client() as other, ThreadPoolExecutor(GUESTS) as threads:
        own = other.post("/api/sessions", json={"kind": "simulation", "world": "room"}).json()["id"]
        stream = f"ws://127.0.0.1:{process.port}/api/sessions/{own}/stream"
        async with stream_at(stream, additional_headers={"Authorization": f"Bearer {TOKEN}"}) as connection:
            watcher = Watcher(connection)
            await watcher.until(lambda: watcher.frames > 2)
            reading = asyncio.create_task(watcher.until(lambda: False))
            process.forget_peak()
            before = process.most_bytes
            attack = [threads.submit(take, number) for number in range(GUESTS)]
            frames = watcher.frames
            asked = 0
            while not all(one.done() for one in attack):
                assert (await asyncio.to_thread(other.get, "/livez")).status_code == 200
                asked += 1
                await asyncio.sleep(0.05)  # the processor is the downloads'
            assert asked > 0
            await eventually(lambda: watcher.frames > frames + 3)
            reading.cancel()
            await asyncio.gather(reading, return_exceptions=True)
    answers = [one.result() for one in attack]
    taken = [answer for answer in answers if answer.status_code == 200]
    print(f"{before / 1e6:.0f} MB before, at most {process.most_bytes / 1e6:.0f} MB; {len(taken)} of {GUESTS} taken")
    assert process.most_bytes < min(MAX_RSS, before + MAX_OF_TWO)
    assert len(taken) >= 2
    assert len({answer.content for answer in taken}) == 1
    cols, rows = Image.open(io.BytesIO(taken[0].content)).size
    assert rows * cols > cells
    for answer in answers:
        if answer.status_code != 200:
            assert (answer.status_code, answer.json()["code"]) == (429, "download.too_many")
            assert int(answer.headers["retry-after"]) > 0


async def test_it_ends_while_clients_read_nothing_of_their_downloads(process: Process) -> None:
    session = await guest_session(process)
    with contextlib.ExitStack() as stack:
        for number in range(6):
            connection = stack.enter_context(socket.create_connection(("127.0.0.1", process.port), timeout=PATIENCE_S))
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            name = "map.pgm" if number < 2 else "map.png"
            connection.sendall(f"GET /api/sessions/{session}/{name} HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".encode())
            if number < 2:
                assert b"200 OK" in await asyncio.to_thread(connection.recv, 4096)
        process.popen.send_signal(signal.SIGTERM)
        _, errors = await asyncio.to_thread(process.popen.communicate, timeout=PATIENCE_S)
    assert process.popen.returncode == 0
    assert "Traceback" not in errors
