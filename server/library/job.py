"""The code of the process that reads a log: reading, resource limits, and progress.

A malicious file can harm only this process, which has limits of memory, processor time and wall time, and ends with the
server.
"""

from __future__ import annotations

import contextlib
import math
import multiprocessing
import multiprocessing.connection
import os
import resource
import signal
import tempfile
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing.sharedctypes import Synchronized
from pathlib import Path
from typing import Any, Protocol, TypeVar

from mapper.core.array_types import UInt8Array
from mapper.core.errors import LimitError, ReadError
from mapper.io.logs.summary import LogSummary, summarise
from mapper.sensors.planar.options import PlanarCut
from server.library.log_pack import write_pack

T = TypeVar("T")
R_co = TypeVar("R_co", covariant=True)

READING = "Reading this log"  #: what most jobs do, in their errors


class WorkerJob(Protocol[R_co]):
    """A job of a worker process, within limits of elapsed and processor time and of address space."""

    @property
    def timeout_s(self) -> float:
        """Longest elapsed time, seconds."""

    @property
    def memory_bytes(self) -> int:
        """Largest address space of the process, bytes."""

    @property
    def work(self) -> Callable[[Any], R_co]:
        """The function that does the job, which is its only argument."""

    def time_error(self) -> LimitError:
        """Return the error for a job that took too long."""


@dataclass(frozen=True, slots=True)
class Job:
    """Read the log file ``source``, pack it into ``pack`` if there is one; ``topic`` names one of several sensors.

    A picture of its map is drawn into ``picture`` if there is one.
    """

    source: str
    pack: str | None
    topic: str | None
    timeout_s: float
    cpu_s: float
    memory_bytes: int  #: of address space
    cut: PlanarCut | None = None  #: how scans are cut out of clouds and depth images; None: as by default
    picture: str | None = None
    volume: bool = False  #: whether the clouds are read for a map in 3D, and not the scans
    folder: str | None = None  #: where temporary files are written; None: in the system's folder

    @property
    def work(self) -> Callable[[Job], LogSummary]:
        """The function that reads it."""
        return read_job

    def time_error(self) -> LimitError:
        """Return the error for a log that takes too long to read."""
        return time_error(self.timeout_s)


_report: Callable[[float], None] | None = None  #: reports the progress of this process


def start_worker(progress: Synchronized[float], pid: Synchronized[int], memory_bytes: int) -> None:
    """Initialize a process of a pool: its limit of address space, its id, and where it reports progress."""
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
    # workers itself: a worker that ended first would count as a log that cannot be read.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    with contextlib.suppress(ValueError, OSError):  # not every system can limit it
        given = resource.getrlimit(resource.RLIMIT_AS)[1]
        # The limit of `ulimit -v` stays if it is the lower one: root could raise it.
        most = memory_bytes if given == resource.RLIM_INFINITY else min(memory_bytes, given)
        resource.setrlimit(resource.RLIMIT_AS, (most, most))


def note_progress(fraction: float) -> None:
    """Report the progress of this process's job, from 0 to 1."""
    if _report is not None:
        _report(min(max(float(fraction), 0.0), 1.0))


def _end_with_server() -> None:
    """End this process when the server is gone, also if the server was killed."""
    server = multiprocessing.parent_process()
    if server is not None:
        multiprocessing.connection.wait([server.sentinel])
        os._exit(1)


class _OutOfTime(BaseException):
    """The job's time is over: no ``Exception``, so that no reader catches it."""


def _out_of_time(number: int, _: object) -> None:
    for other in (signal.SIGALRM, signal.SIGPROF):  # the other one may be due as well, while this one is handled
        signal.signal(other, signal.SIG_IGN)
    raise _OutOfTime(number)


@contextlib.contextmanager
def _timed(timeout_s: float, cpu_s: float, over: tuple[LimitError, LimitError]) -> Iterator[None]:
    """Interrupt the block after ``timeout_s`` seconds of elapsed time or ``cpu_s`` of processor time.

    It raises the first of ``over``, or the second.

    What runs in C for long hears no signal: then the kernel ends the process, after as much processor time again and at
    least one second, in which a process with little time can still say that it is over.
    """
    alarms = ((signal.SIGALRM, signal.ITIMER_REAL, timeout_s), (signal.SIGPROF, signal.ITIMER_PROF, cpu_s))
    used = resource.getrusage(resource.RUSAGE_SELF)
    with contextlib.suppress(ValueError, OSError):
        last = math.ceil(used.ru_utime + used.ru_stime + 2.0 * cpu_s) + 1  # whole seconds, as the kernel counts them
        resource.setrlimit(resource.RLIMIT_CPU, (last, resource.getrlimit(resource.RLIMIT_CPU)[1]))
    try:
        for number, timer, seconds in alarms:
            signal.signal(number, _out_of_time)
            signal.setitimer(timer, seconds)
        yield
    except _OutOfTime as caught:
        raise over[0] if caught.args[0] == signal.SIGALRM else over[1] from None
    finally:
        for _, timer, _ in alarms:
            signal.setitimer(timer, 0.0)


def read_job(job: Job) -> LogSummary:
    """Do the job and return what the log holds.

    Raises :class:`ReadError` or :class:`LimitError`, which cross to the server with their codes.
    """
    return bounded(job.timeout_s, job.cpu_s, lambda: _read(job))


def bounded(timeout_s: float, cpu_s: float, work: Callable[[], T], doing: str = READING, code: str = "log") -> T:
    """Return what ``work`` returns; raise :class:`LimitError` where it needs more time or memory than it may have.

    ``doing`` is what the errors say that it does, and ``code`` the first part of their codes.
    """
    note_progress(0.0)
    more = LimitError(f"{code}.time", f"{doing} takes more than the {cpu_s:.3g} s of processor time it may have.")
    try:
        with _timed(timeout_s, cpu_s, (time_error(timeout_s, doing, code), more)):
            return work()
    except (MemoryError, ImportError) as error:
        # Where memory runs out in an import, the loader of shared libraries says so as an ImportError.
        if isinstance(error, ModuleNotFoundError):
            raise
        raise LimitError(f"{code}.memory", f"{doing} needs more memory than the server gives to one log.") from None


def _read(job: Job) -> LogSummary:
    from mapper.io.logs import open_robot_log  # noqa: PLC0415 - only the process that reads needs the readers
    from mapper.io.logs.selection import ALL_SENSORS, Selection  # noqa: PLC0415
    from server.library.map_files import is_map  # noqa: PLC0415

    tempfile.tempdir = job.folder  # of this process, which only reads; readers of packed databases write there, too
    if job.volume:
        return _read_volume(job)
    if job.topic is None and is_map(Path(job.source)):
        return _read_map(job)
    if job.topic is None and _holds_volume(job):
        return _read_volume(job)
    selection = ALL_SENSORS if job.topic is None else Selection.of(job.topic, job.cut)
    try:
        log = open_robot_log(Path(job.source), selection=selection, progress=note_progress)
    except ReadError as error:
        if error.code != "log.no_scans" or job.topic is not None:
            raise
        return _read_others(job, error)
    note_progress(1.0)  # a cancelled job ends here and leaves no pack
    _pack(job, lambda path: write_pack(log, path))
    if job.picture is not None:
        from server.library.log_picture import write_picture  # noqa: PLC0415 - Pillow is loaded only for pictures

        with contextlib.suppress(OSError, ValueError, MemoryError):  # a log without a picture can be opened as well
            write_picture(log.first, Path(job.picture))
    return summarise(log.first)


def _holds_volume(job: Job) -> bool:
    from server.library.volume_job import holds_volume  # noqa: PLC0415 - only the process that reads needs the readers

    return holds_volume(Path(job.source))


def _read_volume(job: Job) -> LogSummary:
    """Read what a map in 3D is made of."""
    from server.library.volume_job import read_volume, store_volume, summarise_volume  # noqa: PLC0415

    source = Path(job.source)
    found = read_volume(source, job.topic, note_progress)
    summary = summarise_volume(found, source.name)
    note_progress(1.0)
    store_volume(
        found, None if job.pack is None else Path(job.pack), None if job.picture is None else Path(job.picture)
    )
    return summary


def _read_others(job: Job, no_scans: ReadError) -> LogSummary:
    """Read the clouds or costmaps of a recording that has no scans; raise ``no_scans`` where it has none of them."""
    try:
        return _read_volume(job)
    except ReadError as error:
        if error.code == "clouds.none":
            return _read_costmaps(job, no_scans)
        raise


def _read_costmaps(job: Job, no_scans: ReadError) -> LogSummary:
    """Read the costmaps of a recording that has no scans; raise ``no_scans`` where it has none of them either."""
    from mapper.io.costmaps import open_costmaps  # noqa: PLC0415 - few logs have them
    from server.library.costmap_pack import costmap_codes, summarise_costmaps, write_costmap_pack  # noqa: PLC0415

    try:
        streams = open_costmaps(Path(job.source), progress=note_progress)
    except ReadError:
        raise no_scans from None
    note_progress(1.0)
    _pack(job, lambda path: write_costmap_pack(streams, path))
    _draw(job, lambda: costmap_codes(streams))
    return summarise_costmaps(streams, Path(job.source).name)


def _read_map(job: Job) -> LogSummary:
    """Read map files."""
    from server.library.map_files import read_map  # noqa: PLC0415
    from server.library.map_pack import map_codes, summarise_map  # noqa: PLC0415 - few uploads are maps

    given = read_map(Path(job.source), "map", Path(tempfile.gettempdir()))
    note_progress(1.0)
    _pack(job, given.write)
    _draw(job, lambda: map_codes(given))
    return summarise_map(given)


def _pack(job: Job, write: Callable[[Path], None]) -> None:
    """Write the pack of a job that has one. Raises :class:`LimitError` where there is no room for it."""
    if job.pack is not None:
        try:
            write(Path(job.pack))
        except OSError as error:
            message = "What was read of the log could not be stored; the server's disk may be full."
            raise LimitError("log.storage", message) from error


def _draw(job: Job, codes: Callable[[], UInt8Array]) -> None:
    """Draw the picture of a job that has one; what it shows can be opened without it as well."""
    if job.picture is not None:
        from server.library.log_picture import write_codes  # noqa: PLC0415 - Pillow is loaded only for pictures

        with contextlib.suppress(OSError, ValueError, MemoryError):
            write_codes(codes(), Path(job.picture))


def time_error(timeout_s: float, doing: str = READING, code: str = "log") -> LimitError:
    """Return the error for a job that took too long; as :func:`bounded`."""
    return LimitError(f"{code}.time", f"{doing} takes longer than the {timeout_s:.3g} s that the server allows.")
