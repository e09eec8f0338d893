"""A fleet of equal logs on 1, 2 and 4 processes of this machine and on as many Dask workers, and a scheduler's cost."""

from __future__ import annotations

import os
import shutil
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path

from distributed import LocalCluster

from mapper.io.export import write_mcap
from mapper.simulation import sample_log
from server.fleet import Fleet, workers_at
from server.library.workers import Worker

LOGS = 16  #: of the fleet that is timed
TASKS = 500  #: empty ones, of which the scheduler's cost is measured
COUNTS = (1, 2, 4)
MEMORY = 6 << 30


def fleet() -> None:
    """Print seconds of a fleet by workers with the speedup over one, and seconds of the scheduler per log."""
    with tempfile.TemporaryDirectory(prefix="gridbloom-fleet-") as named:
        folder = Path(named)
        paths = [folder / f"{n}.mcap" for n in range(LOGS)]
        with paths[0].open("wb") as file:
            write_mcap(file, sample_log())
        for path in paths[1:]:
            shutil.copy(paths[0], path)
        local = {n: _seconds(paths, folder, None, n) for n in COUNTS}
        dask: dict[int, float] = {}
        empty = 0.0
        for n in COUNTS:
            with LocalCluster(n_workers=n, threads_per_worker=1, dashboard_address=None) as cluster:
                dask[n] = _seconds(paths, folder, cluster.scheduler_address, n)
                if n == COUNTS[0]:
                    empty = _empty_task_s(cluster)
    head = " | ".join(f"{n} worker{'s' if n > 1 else ''}" for n in COUNTS)
    print(f"\n| {LOGS} logs, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} | {head} |")
    print(f"|---|{'---|' * len(COUNTS)}")
    for name, times in (("processes of this machine", local), ("Dask workers, a process for each log", dask)):
        print(f"| {name} | {' | '.join(f'{s:.1f} s, × {times[1] / s:.2f}' for s in times.values())} |")
    print(
        f"\nThe scheduler takes {1e3 * empty:.2f} ms for each task, {100 * LOGS * empty / dask[1]:.2f} % of that fleet."
    )


def _seconds(paths: Sequence[Path], folder: Path, place: str | None, count: int) -> float:
    """Return the seconds of a fleet whose workers have begun before."""
    with ExitStack() as stack:
        leases = folder / "leases"
        leases.mkdir(exist_ok=True)
        workers = stack.enter_context(workers_at(place, count, leases, MEMORY))
        _run(paths[:count], folder / "warm", workers)
        began = time.perf_counter()
        _run(paths, folder / "out", workers)
        seconds = time.perf_counter() - began
    for name in ("warm", "out"):
        shutil.rmtree(folder / name)
    return seconds


def _run(paths: Sequence[Path], out: Path, workers: Sequence[Worker]) -> None:
    whole = Fleet(paths, out)
    with whole.held():
        whole.run(workers, lambda _: None)
    failed = [one.message for one in whole.results.values() if one.failed]
    if failed:
        raise RuntimeError(failed[0])


def _empty_task_s(cluster: LocalCluster) -> float:
    nothing: Callable[[], None] = _nothing
    with cluster.get_client() as client:
        client.submit(nothing, pure=False).result()
        began = time.perf_counter()
        for one in [client.submit(nothing, pure=False) for _ in range(TASKS)]:
            one.result()
        return (time.perf_counter() - began) / TASKS


def _nothing() -> None:
    """An empty task."""
