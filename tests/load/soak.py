"""A soak: visitors come, look, upload, heal, note, share, sign out and leave; what of it stays in the service.

Each visitor deletes what was made. So nothing may be left, and memory, descriptors and threads level off. Meanwhile the
database is locked, the disk is filled and the clock is set (:mod:`tests.load.troubles`), and the service is restarted.
"""

from __future__ import annotations

import contextlib
import os
import sqlite3
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import astuple, dataclass, fields
from itertools import pairwise
from pathlib import Path
from typing import Any

import httpx
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from server.storage import RECORDS_FILE
from tests.hostile.test_clock import PROGRAM, TOKEN
from tests.load.troubles import Disk, lock, set_ahead, set_back
from tests.mapper.slam.worlds import along, drive
from tests.server.cli.poses.test_slam import carmen
from tests.server.service import once_read, until
from tests.server.test_serving import started
from tests.tmpfs import tmpfs

VISITORS = 3  #: at once
HEALED = 4  #: one visit of so many corrects its log by SLAM, which takes a process of its own
SETTLE_S = 8.0  #: after the visits of a part, before it is counted: longer than what sweeps up waits
LIVES = 2  #: of the service, which is restarted in between
PARTS = 8  #: of a life; the first half warms up: what the allocator keeps free still grows then
DISK = "256m"
#: Growth for 1,000 visits that is allowed over the second half of a life, and by how much a count is off by chance.
ALLOWED = {"memory_mb": (5.0, 5.0), "descriptors": (2.0, 2.0), "threads": (2.0, 2.0)}
#: What may be added once in the second half of a life, if it is not added in the end: the C library keeps more memory
#: free from then on, in arenas of threads that were never as busy at the same time before.
STEP = {"memory_mb": 16.0}
#: Growth that is allowed over the whole time, by chance alone: what is kept on the disk.
KEPT = {"files": 2, "rows": 0}


@dataclass(frozen=True, slots=True)
class Left:
    """What a service holds after some ``visits``: ``files`` in its data folder, ``rows`` of its tables of records."""

    visits: int
    memory_mb: float
    descriptors: int
    threads: int
    files: int
    rows: int


class RefusedError(Exception):
    """The service has no room on its disk."""


def _left(pid: int, folder: Path, visits: int) -> Left:
    status = Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    numbers = dict(line.split(":", 1) for line in status.splitlines())
    with contextlib.closing(sqlite3.connect(folder / "library" / RECORDS_FILE)) as records:
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


def _answer(response: httpx.Response) -> Any:
    """Return what was answered. Raises :class:`RefusedError` where the disk is full."""
    if response.status_code == 507:
        raise RefusedError(response.text)
    response.raise_for_status()
    return response.json() if response.headers.get("Content-Type") == "application/json" else None


def _visit(server: str, log: bytes, *, heals: bool) -> None:
    """Sign in, look at a world, upload a log, correct, note, share and open it, delete everything, and sign out."""
    with ExitStack() as stack:
        http = stack.enter_context(httpx.Client(base_url=server, timeout=240.0))
        http.get("/", params={"token": TOKEN}, follow_redirects=True).raise_for_status()
        stack.callback(lambda: http.post("/sign-out"))

        def made(answer: Any, place: str, key: str = "id") -> str:
            """Return the id of what was made, which is deleted in the end, however the visit ends."""
            name = str(answer[key])
            stack.callback(lambda: http.delete(f"{place}/{name}").raise_for_status())
            return name

        world = made(_answer(http.post("/api/sessions", json={"kind": "simulation", "world": "room"})), "/api/sessions")
        address = f"{server.replace('http', 'ws', 1)}/api/sessions/{world}/stream"
        cookie = {"Cookie": "; ".join(f"{name}={value}" for name, value in http.cookies.items())}
        protocols = [Subprotocol("gridbloom.v3")]
        with connect(address, subprotocols=protocols, additional_headers=cookie, max_size=None) as stream:
            for _ in range(4):
                stream.recv()
        http.get(f"/api/sessions/{world}/map.png").raise_for_status()
        name = made(_answer(http.put("/api/logs", params={"name": "soak.log"}, content=log)), "/api/logs")
        if once_read(http, name)["state"] != "ready":
            raise RefusedError(name)
        if heals:
            _answer(http.post(f"/api/logs/{name}/slam", json={}))
            state = until(
                lambda: (now := http.get(f"/api/logs/{name}/slam").json()["state"]) not in ("queued", "running") and now
            )
            if state != "done":
                raise RefusedError(state)
        view = made(_answer(http.post("/api/sessions", json={"kind": "log", "log": name})), "/api/sessions")
        _answer(http.post(f"/api/sessions/{view}/notes", json={"text": "a door", "at_s": 1.0, "scan": 5}))
        http.get(f"/api/sessions/{view}/doctor").raise_for_status()
        token = made(_answer(http.post(f"/api/sessions/{view}/links", json={})), "/api/links", "token")
        with httpx.Client(base_url=server, timeout=240.0) as guest:
            _answer(guest.post(f"/api/shared/{token}/sessions", json={}))


class Visits:
    """Visitors of a service, :data:`VISITORS` at once. One who is refused for a full disk leaves."""

    def __init__(self, log: bytes, disk: Disk) -> None:
        self.done = self.refused = 0
        self._log, self._disk = log, disk
        self._lock = threading.Lock()
        self._failures: list[BaseException] = []

    def come(self, server: str, seconds: float, trouble: Callable[[], None]) -> None:
        """Have visitors come for so long, and after a third of the time the ``trouble``."""
        over = time.monotonic() + seconds
        threads = [threading.Thread(target=self._run, args=(server, over)) for _ in range(VISITORS)]
        for thread in threads:
            thread.start()
        time.sleep(seconds / 3.0)
        trouble()
        for thread in threads:
            thread.join()
        if self._failures:
            raise self._failures[0]

    def _run(self, server: str, over: float) -> None:
        while time.monotonic() < over and not self._failures:
            moment = self._disk.moment()
            try:
                _visit(server, self._log, heals=self.done % HEALED == 0)
            except RefusedError as error:
                with self._lock:
                    self.refused += 1
                    if not self._disk.was_full(moment):
                        self._failures.append(error)
            except (httpx.HTTPError, OSError, AssertionError) as error:
                self._failures.append(error)
            else:
                with self._lock:
                    self.done += 1


@contextmanager
def _life(folder: Path) -> Iterator[tuple[int, str]]:
    """Run the service; yield its process and its address. It must end by itself on SIGTERM."""
    with (folder / "service.log").open("a") as log:
        process, address = started(PROGRAM, folder / "data", GRIDBLOOM_TOKEN=TOKEN, GRIDBLOOM_LOG_LEVEL="error")
        assert process.stdout is not None
        assert process.stderr is not None
        pipes = [
            threading.Thread(target=lambda: log.writelines(process.stderr or ())),
            threading.Thread(target=process.stdout.read),
        ]
        for thread in pipes:
            thread.start()
        try:
            yield process.pid, address.partition("/?")[0]
        finally:
            process.terminate()
            try:
                process.wait(60.0)
            finally:
                process.kill()
                for thread in pipes:
                    thread.join()
        if process.returncode != 0:
            raise RuntimeError(f"the service ended with {process.returncode}")


def soak(minutes: int = 10) -> None:
    """Print what the service holds after each part of the time, and what of it grows; end with 1 where any does."""
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        folder = Path(name)
        (folder / "data").mkdir()
        disk = Disk(folder / "data")
        troubles = {"database locked": lock(folder / "data"), "clock ahead": set_ahead, "clock back": set_back}
        try:
            stack.enter_context(tmpfs(folder / "data", DISK))
            troubles = {"disk full": disk.fill} | troubles
        except PermissionError as error:
            print(f"the disk is never full: {error}")
        room = drive("room", along([(3.4, 3.6), (6.4, 3.6), (6.4, 5.4), (3.4, 5.4), (3.4, 3.6)], 0.4), turn_bias=0.1)
        visits, lives = Visits(carmen(folder / "room.log", room).read_bytes(), disk), list[list[Left]]()
        columns = [field.name for field in fields(Left)]
        print(f"| {' | '.join(columns)} | meanwhile |\n|{'---:|' * len(columns)}---|")
        for _ in range(LIVES):
            counts = list[Left]()
            lives.append(counts)
            with _life(folder) as (pid, server):
                for part in range(PARTS):
                    kind = list(troubles)[part % len(troubles)]
                    trouble = troubles[kind]
                    visits.come(server, 60.0 * minutes / (LIVES * PARTS), lambda: trouble(pid))  # noqa: B023 (ends in it)
                    time.sleep(SETTLE_S)
                    counts.append(_left(pid, folder / "data", visits.done))
                    print(f"| {' | '.join(f'{value:g}' for value in astuple(counts[-1]))} | {kind} |", flush=True)
        print(f"{visits.refused} visits were refused as the disk was full; {LIVES - 1} restarts")
        if not verdict(lives):
            sys.exit(1)


def verdict(lives: list[list[Left]]) -> bool:
    """Print what grows; return whether nothing does."""
    level = True
    for what, (most, chance) in ALLOWED.items():
        for number, counts in enumerate(lives, start=1):
            second = counts[PARTS // 2 - 1 :]
            values = [float(getattr(one, what)) for one in second]
            step = max(later - earlier for earlier, later in pairwise(values[:-1]))
            step = step if chance < step <= STEP.get(what, 0.0) else 0.0
            thousand = max(second[-1].visits - second[0].visits, 1) / 1000.0
            grown = values[-1] - values[0] - step
            is_level = grown <= most * thousand + chance
            level &= is_level
            said = f" besides a step of {step:.1f}" if step else ""
            print(
                f"{what}, life {number}: {grown / thousand:+.1f} for 1,000 visits{said}: "
                f"{'level' if is_level else 'GROWS'}"
            )
    for what, by_chance in KEPT.items():
        grown = getattr(lives[-1][-1], what) - getattr(lives[0][0], what)
        is_level = grown <= by_chance
        level &= is_level
        print(f"{what}: {grown:+d} in all: {'level' if is_level else 'GROWS'}")
    return level
