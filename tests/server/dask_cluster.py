"""A Dask scheduler and workers as processes on loopback, each of which can be killed."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class DaskCluster:
    """The processes; ``folder`` is for the workers' files."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = int(free.getsockname()[1])
        self.address = f"tcp://127.0.0.1:{self.port}"
        self._processes: list[subprocess.Popen[bytes]] = []
        self.scheduler: subprocess.Popen[bytes] | None = None

    def _begin(self, module: str, *options: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.{module}", *options, "--no-dashboard"]
        log = (self._folder / f"{len(self._processes)}.txt").open("wb")
        with log:
            process = subprocess.Popen(command, stdout=log, stderr=log, env=os.environ)
        self._processes.append(process)
        return process

    def begin_scheduler(self) -> None:
        """Start the scheduler, again at the same address."""
        self.scheduler = self._begin("dask_scheduler", "--host", "127.0.0.1", "--port", str(self.port))

    def begin_worker(self, name: str) -> subprocess.Popen[bytes]:
        """Start a worker of one thread, whose files are in the folder :meth:`files`."""
        own = ("--nthreads", "1", "--local-directory", str(self._folder / name), "--host", "127.0.0.1")
        return self._begin("dask_worker", self.address, "--no-nanny", "--death-timeout", "60", *own)

    def jobs(self, name: str) -> list[Path]:
        """Return the folders of the jobs that a worker has."""
        return list((self._folder / name).glob("*/*/gridbloom-*"))

    def kill_scheduler(self) -> None:
        """End the scheduler at once."""
        assert self.scheduler is not None
        kill(self.scheduler)

    def close(self) -> None:
        """End all processes."""
        for process in self._processes:
            kill(process)


def kill(process: subprocess.Popen[bytes]) -> None:
    """End a process at once."""
    if process.poll() is None:
        process.send_signal(signal.SIGKILL)
    process.wait()


@contextmanager
def dask_cluster(folder: Path) -> Iterator[DaskCluster]:
    """Yield a cluster of which nothing was started yet."""
    folder.mkdir(parents=True, exist_ok=True)
    cluster = DaskCluster(folder)
    try:
        yield cluster
    finally:
        cluster.close()
