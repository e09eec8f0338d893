"""The process of a job: its limits of memory, processor time and elapsed time, and its progress.

A malicious file can harm only this process, which has limits of memory, processor time and elapsed time, and ends with
the server.
"""

from __future__ import annotations

import contextlib
import errno
import math
import multiprocessing
import multiprocessing.connection
import os
import resource
import signal
import sys
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing.sharedctypes import Synchronized
from typing import ClassVar, Generic, TypeVar

from mapper.core.errors import LimitError

T = TypeVar("T")
R_co = TypeVar("R_co", covariant=True)

NICENESS = 10  #: added to that of the service by background jobs, so that sessions have priority
READING = "Reading this log"  #: the activity named in errors, by default


@dataclass(frozen=True, slots=True)
class JobLimits:
    """Limits of one job: seconds of elapsed and of processor time, bytes of address space."""

    timeout_s: float = 3600.0
    cpu_s: float = 7200.0
    memory_bytes: int = 6 << 30


class BoundedJob(ABC, Generic[R_co]):
    """Base of the jobs of worker processes, within ``limits``.

    ``DOING`` and ``CODE`` are used in its errors, see :func:`bounded`. A ``BACKGROUND`` job has a lower priority.
    """

    __slots__ = ()

    DOING: ClassVar[str] = READING
    CODE: ClassVar[str] = "log"
    BACKGROUND: ClassVar[bool] = False

    limits: JobLimits

    @abstractmethod
    def compute(self) -> R_co:
        """Return the result of the job."""

    def do(self) -> R_co:
        """Return the result, in the process of the job. Raises like :func:`bounded`."""
        if self.BACKGROUND:
            lower_priority()
        return bounded(self.limits.timeout_s, self.limits.cpu_s, self.compute, self.DOING, self.CODE)

    def time_error(self) -> LimitError:
        """Return the error for a job that took too long."""
        return time_error(self.limits.timeout_s, self.DOING, self.CODE)


_report: Callable[[float], None] | None = None  #: reports the progress of this process


def start_worker(progress: Synchronized[float], pid: Synchronized[int], memory_bytes: int) -> None:
    """Initialize a process of a pool: its limit of address space, its id, and its progress variable."""
    pid.value = os.getpid()
    threading.Thread(target=_end_with_server, name="end with the server", daemon=True).start()

    def report(fraction: float) -> None:
        progress.value = fraction

    begin(memory_bytes, report)


def begin(memory_bytes: int, report: Callable[[float], None]) -> None:
    """Limit this process permanently, and report its progress to ``report``."""
    global _report  # noqa: PLW0603 - a worker process has no other place that outlives a job
    _report = report
    # Ctrl-C, and a service manager that stops all processes of the service, signal this one too. The server ends its
    # workers itself. If a worker ended first, its log would count as unreadable.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    with contextlib.suppress(ValueError, OSError):  # some systems cannot limit it
        hard_limit = resource.getrlimit(resource.RLIMIT_AS)[1]
        # A lower limit from `ulimit -v` is kept, because root could raise it.
        most = memory_bytes if hard_limit == resource.RLIM_INFINITY else min(memory_bytes, hard_limit)
        resource.setrlimit(resource.RLIMIT_AS, (most, most))


def note_progress(fraction: float) -> None:
    """Report the progress of this process's job, from 0 to 1."""
    if _report is not None:
        _report(min(max(float(fraction), 0.0), 1.0))


def _end_with_server() -> None:
    """End this process when the server is gone, even if the server was killed."""
    server = multiprocessing.parent_process()
    if server is not None:
        multiprocessing.connection.wait([server.sentinel])
        os._exit(1)


class _OutOfTime(BaseException):
    """The job's time is over. Not an ``Exception``, so that no reader catches it."""


#: Seconds until it is raised again, because Python ignores exceptions in weak reference callbacks and finalizers.
AGAIN_S = 0.2


def _out_of_time(number: int, _: object) -> None:
    other = signal.SIGPROF if number == signal.SIGALRM else signal.SIGALRM
    signal.signal(other, signal.SIG_IGN)  # it may be due as well while this one is handled
    raise _OutOfTime(number)


@contextlib.contextmanager
def _timed(timeout_s: float, cpu_s: float, over: tuple[LimitError, LimitError]) -> Iterator[None]:
    """Interrupt the block after ``timeout_s`` seconds of elapsed time or ``cpu_s`` of processor time.

    It raises the first of ``over``, or the second. Long-running C code does not receive the signal. In that case the
    kernel ends the process, after the same processor time again and at least one second, in which a process with little
    time can still report its timeout.
    """
    alarms = ((signal.SIGALRM, signal.ITIMER_REAL, timeout_s), (signal.SIGPROF, signal.ITIMER_PROF, cpu_s))
    used = resource.getrusage(resource.RUSAGE_SELF)
    limits = resource.getrlimit(resource.RLIMIT_CPU)
    with contextlib.suppress(ValueError, OSError):
        last = math.ceil(used.ru_utime + used.ru_stime + 2.0 * cpu_s) + 1  # whole seconds, as counted by the kernel
        resource.setrlimit(resource.RLIMIT_CPU, (last, limits[1]))
    handlers = {number: signal.getsignal(number) for number, _, _ in alarms}
    try:
        for number, timer, seconds in alarms:
            signal.signal(number, _out_of_time)
            signal.setitimer(timer, seconds, AGAIN_S)
        yield
    except _OutOfTime as caught:
        raise over[0] if caught.args[0] == signal.SIGALRM else over[1] from None
    finally:
        for _, timer, _ in alarms:
            signal.setitimer(timer, 0.0)
        # A process may do other work later, which the limit would end.
        for number, handler in handlers.items():
            signal.signal(number, handler)
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_CPU, limits)


def bounded(timeout_s: float, cpu_s: float, work: Callable[[], T], doing: str = READING, code: str = "log") -> T:
    """Return the result of ``work``; raise :class:`LimitError` if it needs more time or memory than allowed.

    ``doing`` names its activity in the errors, and ``code`` is the first part of their codes.
    """
    note_progress(0.0)
    more = LimitError(f"{code}.time", f"{doing} takes more than the {cpu_s:.3g} s of processor time it may have.")
    try:
        with _timed(timeout_s, cpu_s, (time_error(timeout_s, doing, code), more)):
            return work()
    except (MemoryError, ImportError, OSError) as error:
        # If memory runs out during an import, the loader of shared libraries raises ImportError, and reading a folder
        # of modules raises OSError.
        if isinstance(error, ModuleNotFoundError) or (isinstance(error, OSError) and error.errno != errno.ENOMEM):
            raise
        raise LimitError(f"{code}.memory", f"{doing} needs more memory than the server gives to one log.") from None


def time_error(timeout_s: float, doing: str = READING, code: str = "log") -> LimitError:
    """Return the error for a job that took too long; the arguments are those of :func:`bounded`."""
    return LimitError(f"{code}.time", f"{doing} takes longer than the {timeout_s:.3g} s that the server allows.")


def lower_priority() -> None:
    """Give the sessions priority; a process of a pool does this once."""
    if sys.platform == "linux":
        niceness = os.getpriority(os.PRIO_PROCESS, os.getppid()) + NICENESS
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, 0, max(niceness, os.getpriority(os.PRIO_PROCESS, 0)))
