"""Memory of a service of several workers: what each further one adds, before its first session and with one."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from tests.load.limited import begun, visitors_of
from tests.load.served import Process, figures, workers
from tests.load.viewer import PERIOD_S

COUNTS = (2, 3, 4)
WANTED_MB = 40.0


def pss_mb(pid: int) -> float:
    """Return a process's memory, of what it shares its share, MB."""
    text = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="ascii")
    return next(int(line.split()[1]) for line in text.splitlines() if line.startswith("Pss:")) * 1024 / 1e6


def _of_all(processes: Sequence[Process]) -> float:
    """Return the memory of the workers and of the process that has forked them, MB."""
    status = Path(f"/proc/{processes[0].pid}/status").read_text(encoding="ascii")
    parent = next(int(line.split()[1]) for line in status.splitlines() if line.startswith("PPid:"))
    return pss_mb(parent) + sum(pss_mb(process.pid) for process in processes)


def footprint(*counts: int) -> None:
    """Print the memory (Pss) of services of these numbers of workers, at least two, and what a further one adds."""
    print(f"load {os.getloadavg()[0]:.1f} before the run; at most {WANTED_MB:g} MB are wanted for each further worker")
    print(f"{'workers':<10}{'idle MB':>12}{'a further':>12}{'with sessions':>15}{'a further':>12}")
    before: tuple[int, float, float] | None = None
    for count in counts or COUNTS:
        with workers(count, 4, count) as (processes, port):
            idle = _of_all(processes)
            streams = begun(port, [visitors_of(worker, count, 1)[0] for worker in range(count)])
            figures(processes, streams, 0, PERIOD_S)
            busy = _of_all(processes)
        added = [""] * 2
        if before is not None:
            more, (_, *then) = count - before[0], before
            added = [f"{(now - old) / more:.0f}" for now, old in zip((idle, busy), then, strict=True)]
        print(f"{count:<10}{idle:>12.0f}{added[0]:>12}{busy:>15.0f}{added[1]:>12}", flush=True)
        before = count, idle, busy
