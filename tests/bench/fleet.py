"""A fleet of equal logs on 1, 2 and 4 processes of this machine and on as many Dask workers, and a scheduler's cost."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path

from distributed import LocalCluster

from mapper.io.export import write_mcap
from mapper.simulation import sample_log
from server.fleet import Fleet, workers_at
from server.jobs.workers import Worker

LOGS = 8  #: of the fleet that is timed
SCANS = 100  #: of each log
TASKS = 200  #: empty ones, of which the scheduler's cost is measured
COUNTS = (1, 2, 4)
MEMORY = 6 << 30
Measured = tuple[float, float]


def fleet() -> None:
    """Print seconds of a fleet by workers with the speedup over one, and what the scheduler costs per log."""
    with tempfile.TemporaryDirectory(prefix="gridbloom-fleet-") as named:
        folder = Path(named)
        paths = [folder / f"{n}.mcap" for n in range(LOGS)]
        with paths[0].open("wb") as file:
            write_mcap(file, sample_log(SCANS))
        for path in paths[1:]:
            shutil.copy(paths[0], path)
        local = {n: _measured(paths, folder, None, n) for n in COUNTS}
        dask: dict[int, Measured] = {}
        empty = (0.0, 0.0)
        for n in COUNTS:
            with LocalCluster(n_workers=n, threads_per_worker=1, dashboard_address="127.0.0.1:0") as cluster:
                dask[n] = _measured(paths, folder, cluster.scheduler_address, n)
                if n == COUNTS[0]:
                    empty = _empty_task_s(cluster)
    head = " | ".join(f"{n} worker{'s' if n > 1 else ''}" for n in COUNTS)
    print(f"\n| {LOGS} logs of {SCANS} scans, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} | {head} |")
    print(f"|---|{'---|' * len(COUNTS)}")
    for name, found in (("processes of this machine", local), ("Dask workers, a process for each log", dask)):
        cells = (f"{s:.1f} s, × {found[1][0] / s:.2f}, {cpu / LOGS:.2f} s of CPU per log" for s, cpu in found.values())
        print(f"| {name} | {' | '.join(cells)} |")
    print(f"\nThe scheduler takes {1e3 * empty[0]:.2f} ms, {1e3 * empty[1]:.2f} ms of them CPU, for each log.")


def _measured(paths: Sequence[Path], folder: Path, place: str | None, count: int) -> Measured:
    """Return elapsed seconds, and those of CPU in the jobs, of a fleet whose workers have begun before."""
    where = "processes" if place is None else "Dask workers"
    print(f"{count} {where} …", end=" ", file=sys.stderr, flush=True)
    with ExitStack() as stack:
        workers = stack.enter_context(workers_at(place, count, MEMORY))
        _run(paths[:count], folder / "warm", workers)
        began = time.perf_counter()
        cpu = _run(paths, folder / "out", workers)
        seconds = time.perf_counter() - began
    print(f"{seconds:.1f} s", file=sys.stderr)
    for name in ("warm", "out"):
        shutil.rmtree(folder / name)
    return seconds, cpu


def _run(paths: Sequence[Path], out: Path, workers: Sequence[Worker]) -> float:
    whole = Fleet(paths, out)
    with whole.held():
        whole.run(workers, lambda _: None)
    facts = [one.facts for one in whole.results.values() if one.facts is not None]
    if len(facts) < len(paths):
        raise RuntimeError(next(one.message for one in whole.results.values() if one.failed))
    return float(sum(one.cpu_s for one in facts))


def _empty_task_s(cluster: LocalCluster) -> tuple[float, float]:
    """Return elapsed seconds of an empty task, and those of CPU of the scheduler and the client, in this process."""
    nothing: Callable[[], None] = _nothing
    with cluster.get_client() as client:
        client.submit(nothing, pure=False).result()
        began, cpu = time.perf_counter(), time.process_time()
        for one in [client.submit(nothing, pure=False) for _ in range(TASKS)]:
            one.result()
        return (time.perf_counter() - began) / TASKS, (time.process_time() - cpu) / TASKS


def _nothing() -> None:
    """An empty task."""
