"""A soak: visitors come, upload, note, share, look and leave, for some minutes; what of it stays in the service.

Each visitor deletes what was made. So nothing may be left, and memory, descriptors and threads level off.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import sqlite3
import tempfile
import threading
import time
from dataclasses import astuple, dataclass, fields
from pathlib import Path

import httpx
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from tests.load.served import service
from tests.server.library.small_logs import carmen
from tests.server.service import once_read

VISITORS = 3  #: at once
SETTLE_S = 8.0  #: after the visits of a part, before it is counted: longer than what sweeps up waits
PARTS = 8  #: of the time; the first half warms up: what the allocator keeps free still grows then
#: Growth for 1,000 visits that is allowed over the second half, and by how much a count is off by chance.
ALLOWED = {
    "memory_mb": (5.0, 5.0),
    "descriptors": (2.0, 2.0),
    "threads": (2.0, 2.0),
    "files": (0.0, 2.0),
    "rows": (0.0, 0.0),
}


@dataclass(frozen=True, slots=True)
class Left:
    """What a service holds after some ``visits``: ``files`` in its data folder, ``rows`` of its tables of records."""

    visits: int
    memory_mb: float
    descriptors: int
    threads: int
    files: int
    rows: int


def _left(pid: int, folder: Path, visits: int) -> Left:
    status = Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    numbers = dict(line.split(":", 1) for line in status.splitlines())
    with contextlib.closing(sqlite3.connect(folder / "library" / "library.db")) as records:
        tables = [
            name
            for (name,) in records.execute("SELECT name FROM sqlite_master WHERE type = 'table'")
            if name not in ("alembic_version", "recorded_changes", "sqlite_sequence", "store")
        ]
        rows = sum(records.execute(f'SELECT count(*) FROM "{name}"').fetchone()[0] for name in tables)
    return Left(
        visits,
        int(numbers["VmRSS"].split()[0]) / 1e3,
        len(list(Path(f"/proc/{pid}/fd").iterdir())),
        int(numbers["Threads"]),
        sum(len(names) for _, _, names in os.walk(folder)),
        rows,
    )


def _visit(server: str) -> None:
    """Come, look at a world, upload a log, note, share and open it, and delete everything."""
    visitor = secrets.token_urlsafe(18)
    with httpx.Client(base_url=server, timeout=240.0, cookies={"gridbloom_visitor": visitor}) as http:
        world = str(
            http.post("/api/sessions", json={"kind": "simulation", "world": "room"}).raise_for_status().json()["id"]
        )
        address = f"{server.replace('http', 'ws', 1)}/api/sessions/{world}/stream"
        with connect(address, subprotocols=[Subprotocol("gridbloom.v3")], max_size=None) as stream:
            for _ in range(4):
                stream.recv()
        http.get(f"/api/sessions/{world}/map.png").raise_for_status()
        log = str(
            http.put("/api/logs", params={"name": "soak.log"}, content=carmen(20)).raise_for_status().json()["id"]
        )
        once_read(http, log)
        view = str(http.post("/api/sessions", json={"kind": "log", "log": log}).raise_for_status().json()["id"])
        http.post(f"/api/sessions/{view}/notes", json={"text": "a door", "at_s": 1.0, "scan": 5}).raise_for_status()
        http.get(f"/api/sessions/{view}/doctor").raise_for_status()
        token = http.post(f"/api/sessions/{view}/links", json={}).raise_for_status().json()["token"]
        with httpx.Client(base_url=server, timeout=240.0) as guest:
            guest.post(f"/api/shared/{token}/sessions", json={}).raise_for_status()
        http.delete(f"/api/links/{token}").raise_for_status()
        for session in (view, world):
            http.delete(f"/api/sessions/{session}").raise_for_status()
        http.delete(f"/api/logs/{log}").raise_for_status()


def _visits(server: str, seconds: float) -> int:
    """Have visitors come for so long; return how many did."""
    until, done, failed = time.monotonic() + seconds, list[int](), list[BaseException]()

    def run() -> None:
        try:
            while time.monotonic() < until and not failed:
                _visit(server)
                done.append(1)
        except (httpx.HTTPError, OSError, AssertionError) as error:
            failed.append(error)

    threads = [threading.Thread(target=run) for _ in range(VISITORS)]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    if failed:
        raise failed[0]
    return len(done)


def soak(minutes: int = 10) -> None:
    """Print what the service holds after each part of the time, and what of it grows."""
    with tempfile.TemporaryDirectory() as name, service(64, 8, options=("--data-dir", name)) as process:
        server, folder, visits, found = f"http://127.0.0.1:{process.port}", Path(name), 0, list[Left]()
        columns = [one.name for one in fields(Left)]
        print(f"| {' | '.join(columns)} |\n|{'---:|' * len(columns)}")
        for _ in range(PARTS):
            visits += _visits(server, 60.0 * minutes / PARTS)
            time.sleep(SETTLE_S)
            found.append(_left(process.pid, folder, visits))
            print(f"| {' | '.join(f'{value:g}' for value in astuple(found[-1]))} |", flush=True)
    first, last = found[PARTS // 2 - 1], found[-1]
    thousand = max(last.visits - first.visits, 1) / 1000.0
    for what, (most, chance) in ALLOWED.items():
        grown = getattr(last, what) - getattr(first, what)
        per_thousand = grown / thousand
        verdict = "level" if grown <= most * thousand + chance else "GROWS"
        print(f"{what}: {per_thousand:+.1f} for 1,000 visits: {verdict}")
