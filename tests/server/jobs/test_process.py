"""The limits of a job's process."""

from __future__ import annotations

import resource
import signal
import subprocess
import sys

import pytest

from mapper.core.errors import LimitError
from server.jobs.process import bounded


def _state() -> tuple[object, ...]:
    handlers = [signal.getsignal(number) for number in (signal.SIGALRM, signal.SIGPROF)]
    return resource.getrlimit(resource.RLIMIT_CPU), *handlers


def test_a_job_leaves_no_limit_behind() -> None:
    """Otherwise the kernel would end the process once its later work has used as much processor time."""
    before = _state()
    during: list[tuple[object, ...]] = []
    bounded(600.0, 600.0, lambda: during.append(_state()))
    assert during[0] != before
    assert _state() == before


def _endless() -> None:
    while True:
        pass


def out_of_time() -> None:
    before = _state()
    with pytest.raises(LimitError, match=r"0\.1 s of processor time"):
        bounded(600.0, 0.1, _endless)
    assert _state() == before


def test_a_job_out_of_time_leaves_no_limit_behind() -> None:
    """In a new process: the kernel counts the time of an old one by ticks, and may be a second ahead of its rusage."""
    code = f"import runpy; runpy.run_path({__file__!r})['out_of_time']()"
    subprocess.run([sys.executable, "-c", code], check=True)
