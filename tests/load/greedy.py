"""A quiet visitor beside one who does at once all that one visitor is allowed, in a process of normal priority.

The service has its default limits. What is beyond them it refuses, and the greedy visitor asks again.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import multiprocessing
import os
import statistics
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Coroutine, Sequence
from itertools import pairwise
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import httpx
import viser
from websockets.asyncio.client import connect
from websockets.exceptions import WebSocketException
from websockets.sync.client import connect as connect_sync
from websockets.typing import Subprotocol

from tests.browser.running import running_server
from tests.load.timed_loop import LIMIT_S
from tests.mapper.slam.worlds import along, drive
from tests.server.cli.poses.test_slam import carmen
from tests.server.library.small_logs import carmen as small_log
from tests.server.scenes.viser_client import CAMERA, Client
from tests.server.service import once_read

PATIENCE_S = 300.0
ADDRESS, VISITOR = "198.51.100.7", "greedy".ljust(24, "_")
HEADERS = {"X-Forwarded-For": ADDRESS, "Cookie": f"gridbloom_visitor={VISITOR}"}
SESSIONS, KEPT, SCENES = 12, 8, 4  #: sessions that are asked for; that one visitor may have; 3D views of each
KINDS = ("commands", "3D views", "pictures", "slow uploads", "slow reading", "SLAM", "")  #: "": all at once
COMMANDS_PER_S = 200.0  #: of each session
PICTURES, UPLOADS, LOGS = 64, 200, 20
LARGE, LARGE_BYTES = 3, 40_000_000  #: logs that take seconds to read, and about how large each is
AGAIN_S = 1.0  #: after which what was refused is asked for again
MOST_NAMED = 15
QUIET_S, BEGUN_S, WATCHED_S = 10.0, 15.0, 40.0  #: alone; from the first greedy request; beside it
STREAM = [Subprotocol("gridbloom.v3")]


class Greedy:
    """The greedy visitor, in an event loop of its own. ``done`` counts what was answered, by kind."""

    def __init__(self, server: str, log: bytes, only: str) -> None:
        self.done: Counter[str] = Counter()
        self._server, self._log, self._only = server, log, only
        self._socket = server.replace("http", "ws", 1)
        limits = httpx.Limits(max_connections=PICTURES + LOGS + SESSIONS)
        self._http = httpx.AsyncClient(base_url=server, timeout=PATIENCE_S, headers=HEADERS, limits=limits)

    async def run(self) -> None:
        """Do everything until it is cancelled."""
        sessions = []
        for seed in range(SESSIONS):
            wanted = {"kind": "simulation", "world": "office", "seed": seed}
            answer = await self._http.post("/api/sessions", json=wanted)
            self.done[f"sessions {answer.status_code}"] += 1
            if answer.is_success:
                sessions.append(str(answer.json()["id"]))
        sessions = sessions[-KEPT:]
        kinds: dict[str, tuple[Callable[[str], Coroutine[Any, Any, None]], list[str]]] = {
            "commands": (self._commands, sessions),
            "3D views": (self._scene, sessions * SCENES),
            "pictures": (self._picture, [sessions[n % len(sessions)] for n in range(PICTURES)]),
            "slow uploads": (self._trickle, [str(n) for n in range(UPLOADS)]),
            "slow reading": (self._large, [str(n) for n in range(LARGE)]),
            "SLAM": (self._slam, [str(n) for n in range(LOGS)]),
        }
        await asyncio.gather(
            *(
                self._again(what, name)
                for kind, (what, names) in kinds.items()
                if self._only in ("", kind)
                for name in names
            )
        )

    async def _again(self, what: Callable[[str], Coroutine[Any, Any, None]], name: str) -> None:
        while True:
            with contextlib.suppress(httpx.HTTPError, WebSocketException, OSError, EOFError):
                await what(name)
                continue
            self.done[f"{what.__name__[1:]} refused"] += 1
            await asyncio.sleep(AGAIN_S)

    async def _commands(self, session: str) -> None:
        """Run a lab at eight times its speed, and move its sliders without a pause."""
        address = f"{self._socket}/api/sessions/{session}/stream"
        async with connect(address, subprotocols=STREAM, additional_headers=HEADERS, max_size=None) as socket:
            await socket.send(json.dumps({"type": "speed", "value": 8}))
            reading = asyncio.create_task(self._acknowledge(socket))
            try:
                for move in range(1 << 40):
                    values = {"window": 0.3 + 0.05 * (move % 2)}
                    await socket.send(json.dumps({"type": "parameters", "values": values}))
                    self.done["commands"] += 1
                    await asyncio.sleep(1.0 / COMMANDS_PER_S)
            finally:
                reading.cancel()

    async def _acknowledge(self, socket: Any) -> None:
        async for message in socket:
            if isinstance(message, bytes):
                seq = int.from_bytes(message[8:12], "little")
                await socket.send(json.dumps({"type": "ack", "seq": seq}))

    async def _scene(self, session: str) -> None:
        protocol = Subprotocol(f"viser-v{viser.__version__}")
        address = f"{self._socket}/scenes/{session}"
        async with connect(
            address, subprotocols=[protocol], additional_headers=HEADERS, max_size=None, compression=None
        ) as socket:
            await Client(socket).send(**CAMERA)
            self.done["3D views"] += 1
            async for message in socket:
                self.done["kB of 3D views"] += len(message) // 1000

    async def _picture(self, session: str) -> None:
        (await self._http.get(f"/api/sessions/{session}/map.png")).raise_for_status()
        self.done["pictures"] += 1

    async def _trickle(self, name: str) -> None:
        """Upload a log at a byte a second, until the service closes the connection."""
        place = httpx.URL(self._server)
        reader, writer = await asyncio.open_connection(place.host, place.port)
        try:
            head = f"PUT /api/logs?name=slow{name} HTTP/1.1\r\nHost: {place.host}:{place.port}\r\n"
            head += "".join(f"{key}: {value}\r\n" for key, value in HEADERS.items())
            writer.write(f"{head}Content-Length: 10000000\r\n\r\n".encode())
            self.done["slow uploads"] += 1
            answer = asyncio.create_task(reader.read(1000))
            while not answer.done():
                writer.write(b"#")
                await writer.drain()
                await asyncio.wait([answer], timeout=1.0)
            raise EOFError(answer.result())
        finally:
            writer.close()

    async def _large(self, name: str) -> None:
        """Upload a large log, another one each time, and delete it once it was read."""
        content = f"# {name} {self.done['large logs']}\n".encode() + self._log * (LARGE_BYTES // len(self._log))
        answer = await self._http.put("/api/logs", params={"name": f"large {name}"}, content=content)
        place = f"/api/logs/{answer.raise_for_status().json()['id']}"
        await self._poll(place, ("queued", "reading"))
        self.done["large logs"] += 1
        await self._http.delete(place)

    async def _slam(self, name: str) -> None:
        """Upload a log, and have its poses corrected again and again."""
        answer = await self._http.put("/api/logs", params={"name": f"log {name}"}, content=self._log)
        place = f"/api/logs/{answer.raise_for_status().json()['id']}"
        await self._poll(place, ("queued", "reading"))
        while True:
            (await self._http.post(f"{place}/slam", json={})).raise_for_status()
            await self._poll(f"{place}/slam", ("queued", "running"))
            self.done["SLAM of logs"] += 1

    async def _poll(self, place: str, states: Sequence[str]) -> None:
        """Ask until what is at ``place`` is in none of ``states``."""
        while (await self._http.get(place)).raise_for_status().json()["state"] in states:  # noqa: ASYNC110 (it is remote)
            await asyncio.sleep(AGAIN_S)


async def _greedy(server: str, log: bytes, only: str, end: Connection) -> None:
    greedy = Greedy(server, log, only)
    task = asyncio.create_task(greedy.run())
    await asyncio.to_thread(end.recv)
    task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task
    end.send(dict(greedy.done))


def _run_greedy(server: str, log: bytes, only: str, end: Connection) -> None:
    asyncio.run(_greedy(server, log, only, end))


class Quiet:
    """The quiet visitor: a lab in which a robot drives, a small log every few seconds, and ``/livez`` between."""

    def __init__(self, server: str) -> None:
        self._server = server
        self._http = httpx.Client(base_url=server, timeout=PATIENCE_S)
        wanted = {"kind": "simulation", "world": "office", "seed": 1}
        self._session = str(self._http.post("/api/sessions", json=wanted).raise_for_status().json()["id"])

    def watch(self, seconds: float) -> tuple[list[float], list[float], list[float]]:
        """Return the times of the frames, of the answers of ``/livez``, and from upload to read log, all seconds."""
        over = time.monotonic() + seconds
        frames, lives, logs = list[float](), list[float](), list[float]()
        threads = [
            threading.Thread(target=self._frames, args=(over, frames)),
            threading.Thread(target=self._lives, args=(over, lives)),
            threading.Thread(target=self._logs, args=(over, logs)),
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        return frames, lives, logs

    def _frames(self, over: float, times: list[float]) -> None:
        address = f"{self._server.replace('http', 'ws', 1)}/api/sessions/{self._session}/stream"
        cookie = {"Cookie": "; ".join(f"{name}={value}" for name, value in self._http.cookies.items())}
        with connect_sync(
            address, subprotocols=STREAM, additional_headers=cookie, max_size=None, open_timeout=PATIENCE_S
        ) as socket:
            while (now := time.monotonic()) < over:
                message = socket.recv(PATIENCE_S)
                if isinstance(message, bytes):
                    socket.send(json.dumps({"type": "ack", "seq": int.from_bytes(message[8:12], "little")}))
                elif message.startswith('{"type":"frame"'):
                    times.append(now)

    def _lives(self, over: float, times: list[float]) -> None:
        with httpx.Client(base_url=self._server, timeout=PATIENCE_S) as http:
            while (began := time.monotonic()) < over:
                http.get("/livez").raise_for_status()
                times.append(time.monotonic() - began)
                time.sleep(0.05)

    def _logs(self, over: float, times: list[float]) -> None:
        with httpx.Client(base_url=self._server, timeout=PATIENCE_S, cookies=dict(self._http.cookies)) as http:
            while (began := time.monotonic()) < over:
                content = small_log(50, start=len(times))
                log = str(
                    http.put("/api/logs", params={"name": "small"}, content=content).raise_for_status().json()["id"]
                )
                state = once_read(http, log)["state"]
                times.append(time.monotonic() - began)
                http.delete(f"/api/logs/{log}").raise_for_status()
                if state != "ready":
                    raise RuntimeError(f"the small log is {state}")
                time.sleep(2.0)


def _row(name: str, frames: list[float], lives: list[float], logs: list[float]) -> str:
    gaps = [later - earlier for earlier, later in pairwise(frames)]
    rate = len(gaps) / max(frames[-1] - frames[0], 1e-9)
    values = (
        f"{rate:.1f}",
        f"{max(gaps):.2f}",
        f"{1e3 * statistics.median(lives):.0f}",
        f"{1e3 * statistics.quantiles(lives, n=100)[-1]:.0f}",
        f"{statistics.median(logs):.2f}",
        f"{max(logs):.2f}",
    )
    return f"{name:<14}" + "".join(f"{value:>14}" for value in values)


def greedy() -> None:
    """Print what the quiet visitor gets alone and beside the greedy one, and what that one got."""
    print(f"load {os.getloadavg()[0]:.1f} before the run; wanted: 15 frames/s, gaps 0.5 s, /livez p99 100 ms, log 3 s")
    names = ("frames/s", "longest gap s", "/livez ms", "p99 ms", "small log s", "longest s")
    print(f"{'':<14}" + "".join(f"{name:>14}" for name in names))
    context = multiprocessing.get_context("spawn")
    with tempfile.TemporaryDirectory() as name:
        corners = [(3.4, 3.6), (6.4, 3.6), (6.4, 5.4), (3.4, 5.4)] * 8
        log = carmen(Path(name) / "room.log", drive("room", along(corners, 0.2), turn_bias=0.05)).read_bytes()
        report = Path(name) / "longest.json"
        program = [sys.executable, "-m", "tests.load.timed_loop", str(report)]
        with running_server(Path(name) / "data", program=program) as server:
            quiet = Quiet(server)
            quiet.watch(2.0)  # modules are loaded with the first session, and with the first log
            print(_row("alone", *quiet.watch(QUIET_S)), flush=True)
            for kind in KINDS:
                mine, other = context.Pipe()
                process = context.Process(target=_run_greedy, args=(server, log, kind, other))
                process.start()
                time.sleep(BEGUN_S)
                print(_row(kind or "all at once", *quiet.watch(WATCHED_S if kind == "" else QUIET_S)), flush=True)
                mine.send("end")
                got: dict[str, int] = mine.recv()
                process.join()
                print("    got " + ", ".join(f"{count} {name}" for name, count in sorted(got.items())), flush=True)
        ran, waited = json.loads(report.read_text(encoding="utf-8"))
        limit = f"{1e3 * LIMIT_S:g} ms"
        for title, is_service in ("the service's event loop", True), ("the event loops of 3D views", False):
            print(f"callbacks of {title} over {limit} of processor time, of {MOST_NAMED} kinds at most")
            for _, what, times, longest, collected in [row for row in ran if row[0] is is_service][:MOST_NAMED]:
                print(f"{1e3 * longest:>8.1f} ms, {1e3 * collected:.1f} of the collector, {times:>6} times: {what}")
        waits = [row for row in waited if row[0]]
        times = sum(row[2] for row in waits)
        print(f"{times} callbacks of the service's waited longer than {limit} for a core or the interpreter's lock")
        for _, what, times, longest in waits[:MOST_NAMED]:
            print(f"{1e3 * longest:>8.1f} ms, {times:>6} times: {what}")
