"""The folder of a process's sockets: nothing of it stays in the temporary folder, also not where it was killed."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Protocol

import pytest

from tests.server.service import until

ROOT = Path(__file__).parents[2]
FOLDER = "from server.process_folder import process_folder as used; print(used(), flush=True); input()"
#: A job's process, and a server of 3D drawings.
SOCKETS = """
from server.jobs.workers import PoolWorker
from server.scenes.viser_server import ViserServer
from types import SimpleNamespace
worker, viser = PoolWorker(1 << 30), ViserServer()
worker.submit(SimpleNamespace(do=dict)).result()
print("begun", flush=True)
input()
viser.stop()
worker.close()
"""


class Start(Protocol):
    def __call__(self, program: str) -> tuple[subprocess.Popen[str], str]: ...


@pytest.fixture
def temporary() -> Iterator[Path]:
    """A temporary folder with a short path: that of a Unix socket has at most 107 bytes."""
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)


@pytest.fixture
def start(temporary: Path) -> Iterator[Start]:
    """Start a program whose temporary folder is that of the test; return it and the first line that it prints."""
    with ExitStack() as stack:

        def begin(program: str) -> tuple[subprocess.Popen[str], str]:
            process = stack.enter_context(
                subprocess.Popen(
                    [sys.executable, "-c", program], cwd=ROOT, env=os.environ | {"TMPDIR": str(temporary)},
                    stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                )
            )  # fmt: skip
            stack.callback(process.kill)
            assert process.stdout is not None
            return process, process.stdout.readline().strip()

        yield begin


def test_a_start_removes_the_folders_of_killed_processes_alone(start: Start, temporary: Path) -> None:
    other = temporary / "gridbloom-of-another-kind"
    other.mkdir()
    killed, first = start(FOLDER)
    killed.kill()
    killed.wait()
    assert Path(first).is_dir()
    _, second = start(FOLDER)
    assert not Path(first).exists()
    ending, third = start(FOLDER)
    assert Path(second).is_dir()
    assert Path(second).stat().st_mode & 0o077 == 0
    ending.communicate("\n")
    assert sorted(temporary.iterdir()) == sorted([other, Path(second)]), third


def test_a_service_that_was_killed_leaves_only_what_the_next_start_removes(start: Start, temporary: Path) -> None:
    killed, said = start(SOCKETS)
    assert said == "begun"
    killed.kill()
    killed.wait()
    (left,) = temporary.iterdir()
    assert any(path.is_socket() for path in left.rglob("*"))
    ended, said = start(SOCKETS)
    assert said == "begun"
    assert not left.exists()
    ended.communicate("\n")
    assert ended.returncode == 0
    until(lambda: not list(temporary.iterdir()))
