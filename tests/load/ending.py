"""Time of the service to end on SIGTERM while sessions compute and viewers watch."""

from __future__ import annotations

import asyncio
import os
import signal
import time

from tests.load.served import service
from tests.load.sessions import begun
from tests.load.viewer import PERIOD_S, Viewer

WATCHED_S = 3.0  #: before the signal


async def _watched(paths: list[str], port: int) -> list[Viewer]:
    """Open the streams, and watch them for :data:`WATCHED_S`; return the viewers, which stay connected."""
    loop = asyncio.get_running_loop()
    viewers = [Viewer(path, port, stalled=i % 10 == 9) for i, path in enumerate(paths)]
    for viewer in viewers:
        await loop.create_connection(lambda viewer=viewer: viewer, "127.0.0.1", port)  # type: ignore[misc]
        await viewer.opened
    until = time.monotonic() + WATCHED_S
    while time.monotonic() < until:
        for viewer in viewers:
            viewer.look()
        await asyncio.sleep(PERIOD_S)
    return viewers


async def _ended(paths: list[str], pid: int, port: int) -> float:
    viewers = await _watched(paths, port)
    began = time.monotonic()
    os.kill(pid, signal.SIGTERM)
    await asyncio.to_thread(os.waitid, os.P_PID, pid, os.WEXITED | os.WNOWAIT)
    lasted = time.monotonic() - began
    for viewer in viewers:
        viewer.close()
    return lasted


def ending(*counts: int) -> None:
    """Print how long it took, for these numbers of sessions."""
    print(f"load {os.getloadavg()[0]:.1f} before the run; a viewer for each session, 1 of 10 stalled")
    for count in counts or (1, 64):
        with service(count, 4) as process:
            seconds = asyncio.run(_ended(begun(process.port, count), process.pid, process.port))
        print(f"{count:>4} sessions: {seconds:.2f} s from SIGTERM to the end of the process", flush=True)
