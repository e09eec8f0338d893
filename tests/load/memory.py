"""Memory of an idle session of the lab and after its end, and the effect of silent connections."""

from __future__ import annotations

import contextlib
import os
import resource
import socket
import time
from pathlib import Path

import httpx

from server.sessions.registry import REAP_EVERY_S
from tests.load.served import Process, service
from tests.load.sessions import begun, who

SESSIONS = 64
SILENT = 10_000
MB = 1e6


def _resident_mb(process: Process) -> float:
    pages = int(Path(f"/proc/{process.pid}/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / MB


def _steady_mb(process: Process) -> float:
    """Return the resident memory once it is the same for so long that memory of ended sessions was given back, MB."""
    last, since = _resident_mb(process), time.monotonic()
    while time.monotonic() - since < REAP_EVERY_S + 1.0:
        time.sleep(0.1)
        now = _resident_mb(process)
        if abs(now - last) > 0.5:
            last, since = now, time.monotonic()
    return last


def memory(*counts: int) -> None:
    """Print the memory of idle sessions, of which so many begin, and the answers beside silent connections."""
    count, silent = (*counts, *(SESSIONS, SILENT)[len(counts) :])[:2]
    print(f"load {os.getloadavg()[0]:.1f} before the run; resident memory of the service, MB")
    with service(count, 4) as process:
        first = begun(process.port, 1)  # what the first session loads is not its own
        before = _steady_mb(process)
        paths = begun(process.port, count - 1)
        with_all = _steady_mb(process)
        with httpx.Client(base_url=f"http://127.0.0.1:{process.port}", timeout=60.0, headers=who(0)) as http:
            for path in (*first, *paths):
                http.delete(path.removesuffix("/stream")).raise_for_status()
            after = _steady_mb(process)
            again = begun(process.port, count - 1)
            repeated = _steady_mb(process)
            for path in again:
                http.delete(path.removesuffix("/stream")).raise_for_status()
            each = (with_all - before) / max(1, count - 1)
            print(f"one session {before:.0f}, {count} sessions {with_all:.0f}: {each:.2f} for each idle session")
            print(f"after their end {after:.0f}; as many again {repeated:.0f}, and ended {_steady_mb(process):.0f}")
            _silence(process, http, silent)


def _silence(process: Process, http: httpx.Client, count: int) -> None:
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, count + 500), hard))
    before, began = _resident_mb(process), time.monotonic()
    times: list[float] = []
    with contextlib.ExitStack() as stack:
        opened = []
        for k in range(count):
            try:
                # The addresses of loopback are as many networks as there may be.
                source = f"127.0.{k % 200}.{1 + k // 200 % 200}"
                one = socket.create_connection(("127.0.0.1", process.port), 5.0, (source, 0))
            except OSError:
                continue
            opened.append(stack.enter_context(one))
            if k % 500 == 499:
                asked = time.monotonic()
                http.get("/livez", headers={"Connection": "close"}).raise_for_status()
                times.append(time.monotonic() - asked)
        lasted, held = time.monotonic() - began, _resident_mb(process)
        open_now = len(list(Path(f"/proc/{process.pid}/fd").iterdir()))
        until = time.monotonic() + 60.0
        while len(list(Path(f"/proc/{process.pid}/fd").iterdir())) > 200 and time.monotonic() < until:
            time.sleep(0.1)
        closed_s = time.monotonic() - began
    print(
        f"{len(opened)} silent connections in {lasted:.1f} s: {open_now} descriptors then, {held - before:+.0f} MB; "
        f"/livez beside them {1e3 * max(times, default=0.0):.0f} ms at most; all closed after {closed_s:.0f} s"
    )
