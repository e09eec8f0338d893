"""The process of which those of jobs are forks: it has the readers, outlives signals, and ends with the service."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.server.service import until

ROOT = Path(__file__).parents[4]


@pytest.fixture
def service(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A process that has a job done in one with the readers loaded; it goes on once ``go`` is in the folder."""
    command = [sys.executable, "-m", "tests.server.library.processing.forked", str(tmp_path / "go")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT) as process:
        yield process
        process.kill()


def processes(service: subprocess.Popen[str]) -> list[int]:
    """Return the ids of the fork server, of the process with the job, and of the service."""
    assert service.stdout is not None
    return [int(pid) for pid in service.stdout.readline().split()]


def runs(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def test_a_job_goes_on_when_all_processes_but_the_service_are_told_to_end(
    service: subprocess.Popen[str], tmp_path: Path
) -> None:
    server, job, _ = processes(service)
    for number in (signal.SIGINT, signal.SIGTERM):
        os.kill(server, number)
        os.kill(job, number)
    (tmp_path / "go").touch()
    assert service.stdout is not None
    assert service.stdout.readline() == "done\n"
    assert runs(server)
    service.communicate()
    assert service.returncode == 0


def test_all_end_with_a_service_that_is_killed(service: subprocess.Popen[str]) -> None:
    pids = processes(service)
    service.kill()
    until(lambda: not any(map(runs, pids)))
