"""The CPU time of ``gridbloom serve`` until the first 200 of ``/readyz``."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path

GRIDBLOOM = "from server.cli import main; main()"


def service_start(processes: int = 10) -> None:
    """Print CPU and elapsed time from the start of the process to the first 200 of /readyz. Linux only.

    Once with the data folder of an earlier run, and once with an empty one, in which the tables of the records have to
    be made. One start before the first that counts leaves Python's byte code in its cache.
    """
    runs: dict[str, list[tuple[float, float]]] = {"of an earlier run": [], "empty": []}
    with tempfile.TemporaryDirectory() as earlier:
        _start(earlier)
        for _ in range(processes):
            runs["of an earlier run"].append(_start(earlier))
            with tempfile.TemporaryDirectory() as empty:
                runs["empty"].append(_start(empty))
    print(f"\n| service, start to /readyz, {processes} processes | CPU, least | median | elapsed, least | median |")
    print("|---|---|---|---|---|")
    for folder, times in runs.items():
        columns = [
            f"{measure(values):.2f} s" for values in zip(*times, strict=True) for measure in (min, statistics.median)
        ]
        print(f"| data folder {folder} | {' | '.join(columns)} |")


def _start(folder: str) -> tuple[float, float]:
    """Return the CPU time and the seconds that one process took."""
    began = time.perf_counter()
    service = subprocess.Popen(
        [sys.executable, "-c", GRIDBLOOM, "serve", "--port", "0", "--data-dir", folder],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert service.stdout is not None
        address = service.stdout.readline().split()[-1]
        # The socket listens before the application is made: the request waits in its backlog and is asked only once.
        with urllib.request.urlopen(f"{address}readyz") as answer:
            assert answer.status == 200
        return cpu_s(service.pid), time.perf_counter() - began
    finally:
        service.terminate()
        service.wait()


def cpu_s(pid: int) -> float:
    """Return the user and system time of all threads of a process, in steps of 10 ms (proc_pid_stat(5))."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
