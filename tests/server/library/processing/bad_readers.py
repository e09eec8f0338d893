"""Jobs for the reading process whose readers misbehave; each is run by its name there."""

from __future__ import annotations

import itertools
import os
import resource
import signal
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from mapper.io.logs import opening
from mapper.io.logs.summary import LogSummary
from mapper.sensors.robot_log import RobotLog
from server.library.processing import reading
from tests.server.library.small_logs import carmen

BAD = carmen(2).replace(b"FLASER 3 1.0", b"FLASER 3 6.0")  #: the log that they read so badly
LEFT = "left-by-a-crash-"  #: begins the name of a temporary folder
OPEN = "open_robot_log"  #: what the job imports from there and calls


def instead(job: Callable[[reading.Job], LogSummary]) -> property:
    """Return what takes the place of ``Job.do``: a function of this module, which the process finds by its name."""
    return property(lambda of: partial(job, of))


def _with(reader: Callable[..., Any], job: reading.Job) -> LogSummary:
    good = getattr(opening, OPEN)

    def read(path: Any, **options: Any) -> RobotLog:
        if path.read_bytes() == BAD:
            reader()
        log: RobotLog = good(path, **options)
        return log

    setattr(opening, OPEN, read)
    try:
        return job.do()
    finally:
        setattr(opening, OPEN, good)


def crash(job: reading.Job) -> LogSummary:
    """Crash with a temporary file that nobody removes."""

    def write_and_end() -> None:
        (Path(tempfile.mkdtemp(prefix=LEFT)) / "unpacked").write_bytes(BAD)
        os.kill(os.getpid(), signal.SIGSEGV)

    return _with(write_and_end, job)


def leave(job: reading.Job) -> LogSummary:
    return _with(lambda: os._exit(0), job)


def _spin() -> None:
    while True:
        pass


def loop(job: reading.Job) -> LogSummary:
    return _with(_spin, job)


def loop_in_c(job: reading.Job) -> LogSummary:
    """No signal is heard in there."""
    return _with(lambda: sum(itertools.repeat(1)), job)


def sleep(job: reading.Job) -> LogSummary:
    return _with(lambda: time.sleep(1000), job)


def _eat() -> None:
    held = []
    while True:
        held.append(bytearray(64 << 20))


def eat(job: reading.Job) -> LogSummary:
    return _with(_eat, job)


def _raise() -> None:
    raise RuntimeError("a defect")


def defect(job: reading.Job) -> LogSummary:
    return _with(_raise, job)


def disk_full(job: reading.Job) -> LogSummary:
    """The result cannot be kept: no file may be larger than a hundred bytes."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:
        return _with(lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100, hard)), job)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
