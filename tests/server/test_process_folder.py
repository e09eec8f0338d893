"""The folder of a process's sockets: nothing of it stays in the temporary folder, also not where it was killed."""

from __future__ import annotations

import os
import subprocess
import sys
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
from server.library.workers import PoolWorker
from server.scenes.viser_server import ViserServer
from os import getpid
worker, viser = PoolWorker(1 << 30), ViserServer()
worker.run(type, 0).result()
print("begun", flush=True)
input()
viser.stop()
worker.close()
"""


class Start(Protocol):
    def __call__(self, program: str) -> tuple[subprocess.Popen[str], str]: ...


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Start a program whose temporary folder is that of the test; return it and the first line that it prints."""
    with ExitStack() as stack:

        def begin(program: str) -> tuple[subprocess.Popen[str], str]:
            process = stack.enter_context(
                subprocess.Popen(
                    [sys.executable, "-c", program], cwd=ROOT, env=os.environ | {"TMPDIR": str(tmp_path)},
                    stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                )
            )  # fmt: skip
            stack.callback(process.kill)
            assert process.stdout is not None
            return process, process.stdout.readline().strip()

        yield begin


def test_a_start_removes_the_folders_of_killed_processes_alone(start: Start, tmp_path: Path) -> None:
    other = tmp_path / "gridbloom-of-another-kind"
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
    assert sorted(tmp_path.iterdir()) == sorted([other, Path(second)]), third


def test_a_service_that_was_killed_leaves_only_what_the_next_start_removes(start: Start, tmp_path: Path) -> None:
    killed, said = start(SOCKETS)
    assert said == "begun"
    killed.kill()
    killed.wait()
    (left,) = tmp_path.iterdir()
    assert any(path.is_socket() for path in left.rglob("*"))
    ended, said = start(SOCKETS)
    assert said == "begun"
    assert not left.exists()
    ended.communicate("\n")
    assert ended.returncode == 0
    until(lambda: not list(tmp_path.iterdir()))
