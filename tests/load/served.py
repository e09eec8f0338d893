"""The service and the echo server as processes of their own, for the runs of this folder."""

from __future__ import annotations

import asyncio
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx
import numpy as np

from tests.browser.running import free_port
from tests.haproxy import running_haproxy
from tests.load.viewer import watch
from tests.server.library.postgresql import running_postgresql
from tests.server.service import until

SECONDS = 10.0


@dataclass(frozen=True, slots=True)
class Process:
    """A running server."""

    pid: int
    port: int


@dataclass(frozen=True, slots=True)
class Figures:
    """Figures of a server and its viewers: frames a second of the slowest and of the middle viewer, ages of
    the newest frame at a look beyond the viewer's own period, milliseconds, cores, cores of the viewers themselves,
    which share the machine, and µs of the server's processor time per frame.
    """

    slowest: float
    middle: float
    p99_ms: float
    cores: float
    viewers_cores: float
    us_per_frame: float
    text_bytes: int
    tile_bytes: int


@contextmanager
def _process(command: Sequence[str], **environment: str) -> Iterator[Process]:
    running = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=os.environ | environment
    )
    try:
        assert running.stdout is not None
        line = running.stdout.readline()
        found = re.search(r"(\d+)/?\s*$", line)
        if found is None:
            raise RuntimeError(f"the server did not start: {line!r}")
        yield Process(running.pid, int(found[1]))
    finally:
        running.terminate()
        running.wait(30)


@contextmanager
def service(sessions: int, clients: int, threads: int | None = None, options: Sequence[str] = ()) -> Iterator[Process]:
    """Run the service with room for so many sessions, and clients of each; ``threads`` compute maps, None: as set.

    ``options`` are more of the command's: its workers, or stores that it shares with others.
    """
    with tempfile.TemporaryDirectory() as folder:
        limits = {
            "GRIDBLOOM_MAX_SESSIONS": str(sessions),
            "GRIDBLOOM_MAX_SESSIONS_PER_VISITOR": str(sessions),
            "GRIDBLOOM_MAX_CLIENTS_PER_SESSION": str(clients),
            "GRIDBLOOM_MAX_TOTAL_CELLS": str(1 << 30),
            "GRIDBLOOM_LOG_LEVEL": "error",
        }
        if threads is not None:
            limits["GRIDBLOOM_THREADS"] = str(threads)
        command = [
            sys.executable,
            "-c",
            "from server.cli import main; main()",
            "serve",
            "--port",
            "0",
            "--data-dir",
            folder,
            *options,
        ]
        with _process(command, **limits) as process:
            yield process


@contextmanager
def workers(sessions: int, clients: int, count: int) -> Iterator[tuple[list[Process], int]]:
    """Run one service of so many worker processes; yield these and the port once it answers.

    One worker is the service's own process; several come after the process that forks them, which has no other work.
    """
    with (
        service(sessions, clients, options=["--workers", str(count)]) as supervisor,
        httpx.Client(base_url=f"http://127.0.0.1:{supervisor.port}", timeout=60.0) as http,
    ):
        until(lambda: _is_ready(http))
        pids = [str(supervisor.pid)]
        if count > 1:
            children = Path(f"/proc/{supervisor.pid}/task/{supervisor.pid}/children")
            pids = children.read_text(encoding="ascii").split()
        yield [Process(int(pid), supervisor.port) for pid in pids], supervisor.port


@contextmanager
def replicas(sessions: int, clients: int, count: int) -> Iterator[tuple[list[Process], int]]:
    """Run so many services of one thread each on one PostgreSQL and one folder, behind HAProxy.

    Yields the services, and the proxy's port once it reaches them.
    """
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        cluster = stack.enter_context(running_postgresql())
        stores = ["--database", cluster.new_database(), "--blobs", str(folder / "blobs")]
        services = [stack.enter_context(service(sessions, clients, 1, stores)) for _ in range(count)]
        port = free_port()
        address = stack.enter_context(running_haproxy(folder, port, [one.port for one in services]))
        with httpx.Client(base_url=address, timeout=60.0) as http:
            until(lambda: _is_ready(http))
        yield services, port


def _is_ready(http: httpx.Client) -> bool:
    try:
        return http.get("/readyz").is_success
    except httpx.TransportError:
        return False


@contextmanager
def echo(text_bytes: int, tile_bytes: int) -> Iterator[Process]:
    """Run the echo server."""
    with _process([sys.executable, "-m", "tests.load.echo", str(text_bytes), str(tile_bytes)]) as process:
        yield process


def figures(processes: Sequence[Process], streams: Sequence[tuple[int, str]], stalled: int, period_s: float) -> Figures:
    """Watch ``streams``, ports and paths, the last ``stalled`` of them without reading.

    Return what the viewers saw, and what it cost the ``processes`` in the same seconds.
    """
    pids = [process.pid for process in processes]
    seen, lasted, cpu, own = asyncio.run(watch(streams, SECONDS, stalled=stalled, pids=pids))
    rates = np.array([len(one.ages) / lasted for one in seen])
    ages = np.concatenate([one.ages for one in seen])
    frames = sum(len(one.ages) for one in seen)
    lengths = [length for one in seen for length in one.messages]
    return Figures(
        float(rates.min()),
        float(np.median(rates)),
        1e3 * (float(np.percentile(ages, 99)) - period_s),
        cpu / lasted,
        own / lasted,
        1e6 * cpu / frames,
        int(np.mean(lengths[0::2])),
        int(np.mean(lengths[1::2])),
    )
