"""Many lab sessions with a viewer each, a tenth of the viewers stalled.

Either in one service, beside an echo server on the same sockets, or spread over several services.
"""

from __future__ import annotations

import os
from contextlib import ExitStack
from itertools import zip_longest

import httpx

from tests.load.served import Figures, Process, echo, figures, service
from tests.load.viewer import PERIOD_S

WHO = {"Cookie": "gridbloom_visitor=" + "load".ljust(24, "_")}
COUNTS = (16, 32, 64, 100, 200)


def begun(process: Process, count: int) -> list[str]:
    """Begin so many sessions of the lab; return the paths of their streams."""
    with httpx.Client(base_url=f"http://127.0.0.1:{process.port}", timeout=120.0, headers=WHO) as http:
        answers = [
            http.post("/api/sessions", json={"kind": "simulation", "world": "office", "seed": seed})
            for seed in range(count)
        ]
        return [str(answer.raise_for_status().json()["stream"]) for answer in answers]


def _streams(process: Process, count: int) -> list[tuple[Process, str]]:
    return [(process, path) for path in begun(process, count)]


def row(name: str, one: Figures) -> str:
    """Return a line of the table."""
    numbers = (one.slowest, one.middle, one.p99_ms, one.cores, one.viewers_cores, one.us_per_frame)
    return f"{name:<20}" + "".join(
        f"{value:>11.{digits}f}" for value, digits in zip(numbers, (1, 1, 0, 2, 2, 0), strict=True)
    )


HEAD = f"{'':<20}" + "".join(
    f"{name:>11}" for name in ("slowest/s", "median/s", "p99 +ms", "cores", "viewers'", "µs/frame")
)


def sessions(*counts: int) -> None:
    """Print what the viewers saw and what it cost, for these numbers of sessions."""
    print(f"load {os.getloadavg()[0]:.1f} before the run; 10 looks a second, 1 of 10 viewers stalled")
    print(HEAD)
    for count in counts or COUNTS:
        stalled = count // 10
        with service(count, 4) as process:
            ours = figures(_streams(process, count), stalled, PERIOD_S)
        with echo(ours.text_bytes, ours.tile_bytes) as process:
            theirs = figures([(process, "/")] * count, stalled, PERIOD_S)
        print(row(f"{count} sessions", ours))
        print(row(f"{count} echoes", theirs))
        print(f"{'ratio':<20}{'':>55}{ours.us_per_frame / theirs.us_per_frame:>11.1f}", flush=True)


def services(*counts: int) -> None:
    """Print the figures of these numbers of sessions in one service, and spread over a service for each core.

    Each of several services computes on one thread.
    """
    cores = len(os.sched_getaffinity(0))
    print(f"load {os.getloadavg()[0]:.1f} before the run; 10 looks a second, 1 of 10 viewers stalled")
    print(HEAD)
    for count in counts or (200,):
        for parts in (1, cores):
            with ExitStack() as stack:
                each = [count // parts + (n < count % parts) for n in range(parts)]
                threads = None if parts == 1 else 1
                streams = [_streams(stack.enter_context(service(one, 4, threads)), one) for one in each]
                mixed = [one for turn in zip_longest(*streams) for one in turn if one is not None]
                ours = figures(mixed, count // 10, PERIOD_S)
            print(row(f"{count} in {parts}", ours), flush=True)
