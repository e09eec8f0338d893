"""Many lab sessions with a viewer each, a tenth of the viewers stalled.

Either in one service, beside an echo server on the same sockets, or spread over several services.
"""

from __future__ import annotations

import os

import httpx

from tests.load.served import Figures, echo, figures, replicas, service
from tests.load.served import workers as several_workers
from tests.load.viewer import PERIOD_S

COUNTS = (16, 32, 64, 100, 200)


def who(visitor: int) -> dict[str, str]:
    """Return the headers of a visitor's requests."""
    return {"Cookie": f"gridbloom_visitor={f'load{visitor}'.ljust(24, '_')}"}


def begun(port: int, count: int, visitors: int = 1) -> list[str]:
    """Begin so many sessions of the lab, each of the next of so many visitors; return the paths of their streams."""
    with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=120.0) as http:
        answers = [
            http.post(
                "/api/sessions",
                json={"kind": "simulation", "world": "office", "seed": seed},
                headers=who(seed % visitors),
            )
            for seed in range(count)
        ]
        return [str(answer.raise_for_status().json()["stream"]) for answer in answers]


def streams(port: int, count: int, visitors: int = 1) -> list[tuple[int, str]]:
    """Begin sessions as :func:`begun` does; return the port and the path of each stream."""
    return [(port, path) for path in begun(port, count, visitors)]


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
            ours = figures([process], streams(process.port, count), stalled, PERIOD_S)
        with echo(ours.text_bytes, ours.tile_bytes) as process:
            theirs = figures([process], [(process.port, "/")] * count, stalled, PERIOD_S)
        print(row(f"{count} sessions", ours))
        print(row(f"{count} echoes", theirs))
        print(f"{'ratio':<20}{'':>55}{ours.us_per_frame / theirs.us_per_frame:>11.1f}", flush=True)


def workers(*counts: int) -> None:
    """Print the figures of these numbers of sessions in one process, and in a worker process for each core."""
    cores = len(os.sched_getaffinity(0))
    print(f"load {os.getloadavg()[0]:.1f} before the run; 10 looks a second, 1 of 10 viewers stalled")
    print(HEAD)
    for count in counts or (1, 200):
        with service(count, 4) as process:
            one = figures([process], streams(process.port, count, count), count // 10, PERIOD_S)
        print(row(f"{count} in 1", one), flush=True)
        with several_workers(count, 4, cores) as (several, port):
            more = figures(several, streams(port, count, count), count // 10, PERIOD_S)
        print(row(f"{count} in {cores} workers", more), flush=True)


def services(*counts: int) -> None:
    """Print the figures of these numbers of sessions in one service, and in a service for each core behind HAProxy.

    Each of several services computes on one thread. What the proxy and the database take is not among the cores.
    """
    cores = len(os.sched_getaffinity(0))
    print(f"load {os.getloadavg()[0]:.1f} before the run; 10 looks a second, 1 of 10 viewers stalled")
    print(HEAD)
    for count in counts or (200,):
        with service(count, 4) as process:
            one = figures([process], streams(process.port, count), count // 10, PERIOD_S)
        print(row(f"{count} in 1", one), flush=True)
        with replicas(count, 4, cores) as (several, port):
            more = figures(several, streams(port, count, count), count // 10, PERIOD_S)
        print(row(f"{count} in {cores}", more), flush=True)
