"""The process that forks the workers of a service, and replaces those that end.

It loads the code and the kernels first, so that the workers share that memory. It has no threads and no event loop,
because forked processes would lose the former and share the latter. Signals: SIGTERM and SIGINT end the service, SIGHUP
replaces the workers one after the other.
"""

from __future__ import annotations

import contextlib
import gc
import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import NoReturn

import structlog

from server.workers.handover import Channel
from server.workers.shared import Shared
from server.workers.worker import REPLACE, Worker

SIGNALS = frozenset({signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGCHLD})
END_S = 8.0  #: seconds that workers have to end before they are killed
STARTS_S = 2.0  #: least time between two starts of a worker, which may end again and again

_log = structlog.get_logger(__name__)


def in_child(work: Callable[[], None]) -> None:
    """Run ``work`` in a forked process, which may have threads, and wait for it. Exits with its status unless 0."""
    child = os.fork()
    if not child:
        _end_after(work)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if status:
        raise SystemExit(status if status > 0 else 1)


def supervise(workers: int, serve: Callable[[Worker], None], class_code: str | None = None) -> None:
    """Fork ``workers`` processes, each of which calls ``serve`` once; return when a signal has ended the service.

    ``class_code`` is that of a class that is open from the start.
    """
    channels = [Channel.make() for _ in range(workers)]
    shared = Shared.make(workers, class_code)
    alive, held = os.pipe()  # the workers get end-of-file when this process ends, for whatever reason

    def run(number: int) -> None:
        os.close(held)
        serve(Worker.of(number, channels, shared, alive))

    gc.collect()
    gc.freeze()  # the collector would write into memory that the workers share
    with _blocked():
        _Supervisor(workers, run, shared).watch()


class _Supervisor:
    """The running workers by their process, and when each number is due for a restart."""

    def __init__(self, workers: int, run: Callable[[int], None], shared: Shared) -> None:
        self._run, self._shared = run, shared
        self._numbers: dict[int, int] = {}
        self._began: dict[int, float] = {}
        self._due: dict[int, float] = {}
        self._to_replace: list[int] = []
        for number in range(workers):
            self._start(number)

    def _start(self, number: int) -> None:
        child = os.fork()
        if not child:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
            signal.signal(signal.SIGHUP, signal.SIG_IGN)  # of a closed terminal; the supervisor decides
            _end_after(partial(self._run, number))
        self._numbers[child] = number
        self._began[number] = time.monotonic()

    def watch(self) -> None:
        """Replace workers that end until a signal ends the service; then end the workers."""
        while True:
            wait_s = max(0.0, min(self._due.values(), default=time.monotonic() + 3600.0) - time.monotonic())
            signalled = signal.sigtimedwait(SIGNALS, wait_s)
            number = None if signalled is None else signalled.si_signo
            if number in (signal.SIGTERM, signal.SIGINT):
                break
            if number == signal.SIGHUP:
                self._to_replace = sorted(self._numbers.values())
                self._replace_next()
            self._reap()
            for due in [number for number, at in self._due.items() if at <= time.monotonic()]:
                del self._due[due]
                self._start(due)
                self._replace_next()
        self._end()

    def _replace_next(self) -> None:
        """End the next worker to be replaced, after its uploads; the previous one has been restarted."""
        if self._to_replace and not self._due:
            number = self._to_replace.pop(0)
            for process, other in self._numbers.items():
                if other == number:
                    os.kill(process, REPLACE)

    def _reap(self) -> None:
        """Handle workers that have ended."""
        for process in list(self._numbers):
            ended, status = os.waitpid(process, os.WNOHANG)
            if not ended:
                continue
            number = self._numbers.pop(process)
            self._shared.clear(number)
            self._due[number] = max(time.monotonic(), self._began[number] + STARTS_S)
            _log.warning("a worker has ended", worker=number, status=os.waitstatus_to_exitcode(status))

    def _end(self) -> None:
        for process in self._numbers:
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, signal.SIGTERM)
        deadline = time.monotonic() + END_S
        while self._numbers and time.monotonic() < deadline:
            signal.sigtimedwait({signal.SIGCHLD}, 0.2)
            for process in list(self._numbers):
                if os.waitpid(process, os.WNOHANG)[0]:
                    del self._numbers[process]
        for process in self._numbers:
            os.kill(process, signal.SIGKILL)
            os.waitpid(process, 0)


@contextmanager
def _blocked() -> Iterator[None]:
    before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end_after(work: Callable[[], None]) -> NoReturn:
    """Do the work of a forked process and exit like any program, so that exit handlers are called."""
    work()
    raise SystemExit(0)
