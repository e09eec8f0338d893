"""Workers that each have a share of a core, as if each had a slow core of its own: what a further worker costs.

With eight of them a machine of two cores shows what one of sixteen would: what does not grow with the workers, and what
each costs all others. The shares are quotas of control groups (version 1), which root may make.
"""

from __future__ import annotations

import asyncio
import itertools
import os
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import httpx

from server.workers.places import VISITOR_COOKIE, worker_of
from tests.load.served import Process, figures, workers
from tests.load.sessions import HEAD, row
from tests.load.viewer import PERIOD_S, cpu_seconds

COUNTS = (1, 2, 4, 8)
CORES = 0.15  #: of each worker
PERIOD_US = 20_000  #: over which a quota counts
SESSIONS = 32  #: of each worker: more frames than its share can make
WRITERS = 4  #: visitors of each worker who write records, one after the other
SETTLE_S, SECONDS = 5.0, 5.0
GROUPS = Path("/sys/fs/cgroup/cpu")
LOG = "/api/logs/sample-office/tags"


@contextmanager
def limited_to(processes: Sequence[Process], cores: float) -> Iterator[None]:
    """Let each of the processes use so many cores while the block runs. Raises :class:`OSError` where it cannot be."""
    groups = [GROUPS / f"gridbloom-{process.pid}" for process in processes]
    try:
        for group, process in zip(groups, processes, strict=True):
            group.mkdir()
            (group / "cpu.cfs_period_us").write_text(str(PERIOD_US), encoding="ascii")
            (group / "cpu.cfs_quota_us").write_text(str(round(cores * PERIOD_US)), encoding="ascii")
            (group / "cgroup.procs").write_text(str(process.pid), encoding="ascii")
        yield
    finally:
        for group, process in zip(groups, processes, strict=True):
            if group.exists():
                (GROUPS / "cgroup.procs").write_text(str(process.pid), encoding="ascii")
                group.rmdir()


def visitors_of(worker: int, of: int, count: int) -> list[dict[str, str]]:
    """Return the headers of so many visitors whose requests ``worker`` of so many answers."""
    cookies = (f"{VISITOR_COOKIE}={f'limited{n}'.ljust(24, '_')}" for n in itertools.count())
    mine = (one for one in cookies if worker_of(f"GET / HTTP/1.1\r\nCookie: {one}\r\n\r\n".encode(), "", of) == worker)
    return [{"Cookie": one} for one in itertools.islice(mine, count)]


def idle_cores(processes: Sequence[Process]) -> float:
    """Return the cores that the processes use for nothing, once what they do after their start is over."""
    time.sleep(SETTLE_S)
    before = sum(cpu_seconds(process.pid) for process in processes)
    time.sleep(SECONDS)
    return (sum(cpu_seconds(process.pid) for process in processes) - before) / SECONDS


async def writes_per_s(port: int, visitors: Sequence[dict[str, str]]) -> float:
    """Return how many transactions a second the visitors make who give a log tags, each one after the other."""
    until, done = time.monotonic() + SECONDS, 0
    async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{port}", timeout=60.0) as http:

        async def write(visitor: dict[str, str]) -> None:
            nonlocal done
            for n in itertools.count():
                if time.monotonic() >= until:
                    return
                (await http.put(LOG, json={"tags": [f"tag {n}"]}, headers=visitor)).raise_for_status()
                done += 1

        await asyncio.gather(*map(write, visitors))
    return done / SECONDS


def begun(port: int, visitors: Sequence[dict[str, str]]) -> list[tuple[int, str]]:
    """Begin a session of the lab for each visitor; return the port and the path of each stream."""
    wanted = {"kind": "simulation", "world": "office"}
    with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=120.0) as http:
        answers = [
            http.post("/api/sessions", json=wanted | {"seed": seed}, headers=visitor)
            for seed, visitor in enumerate(visitors)
        ]
    return [(port, str(answer.raise_for_status().json()["stream"])) for answer in answers]


def limited(*counts: int) -> None:
    """Print what these numbers of workers send and write, each with the same sessions and the same share of a core."""
    print(f"load {os.getloadavg()[0]:.1f} before the run; {SESSIONS} sessions and {CORES} cores for each worker")
    print(HEAD + f"{'frames/s':>11}{'idle cores':>12}{'writes/s':>10}")
    for count in counts or COUNTS:
        with workers(SESSIONS * count, 4, count) as (processes, port):
            visitors = [visitor for worker in range(count) for visitor in visitors_of(worker, count, SESSIONS)]
            idle = idle_cores(processes)
            streams = begun(port, visitors)
            with limited_to(processes, CORES):
                seen = figures(processes, streams, 0, PERIOD_S)
                writers = [one for worker in range(count) for one in visitors[worker * SESSIONS :][:WRITERS]]
                writes = asyncio.run(writes_per_s(port, writers))
        frames = 1e6 * seen.cores / seen.us_per_frame
        print(row(f"{count} workers", seen) + f"{frames:>11.0f}{idle:>12.3f}{writes:>10.0f}", flush=True)
