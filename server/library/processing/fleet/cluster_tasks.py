"""The tasks of a Dask worker for a log that is sent to it: receive its files, do the job, return the results.

The files of a job are in a folder of the worker, named by the job's ticket, which has three parts: ``log``, the files
that were sent; ``lease``, a file that contains the progress of the job, and without which its process ends; ``out``,
the files that the job produces. The folder is removed when the job ends, and when the lease expires, as after the
service was killed.
"""

from __future__ import annotations

import asyncio
import shutil
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from distributed import get_worker

from server.jobs.workers import do_in_process
from server.library.processing.fleet.fleet_job import FleetJob, MapFacts
from server.version import package_version

if TYPE_CHECKING:
    from distributed import Worker

LEASE_S = 30.0  #: a job ends when it is not renewed for this time
PREFIX = "gridbloom-"  #: of the folders of jobs

_renewed: dict[str, float] = {}  #: by ticket: when its lease was renewed; used only from the worker's event loop
_expiring: set[asyncio.Task[None]] = set()


@dataclass(frozen=True, slots=True)
class Mapped:
    """Result of a job: its facts, and the files that it has produced, by name."""

    facts: MapFacts
    files: dict[str, bytes]


def version() -> str:
    """Return the worker's version of the package."""
    return package_version()


async def begin_job(ticket: str, dask_worker: Worker) -> None:
    """Create the folder of a job. Raises :class:`OSError`."""
    folder = _folder(dask_worker, ticket)
    for name in ("log", "out"):
        (folder / name).mkdir(parents=True)
    (folder / "lease").write_bytes(b"0")
    _renewed[ticket] = time.monotonic()
    expiring = asyncio.create_task(_expire(ticket, folder))
    _expiring.add(expiring)
    expiring.add_done_callback(_expiring.discard)


async def write_piece(ticket: str, name: str, data: bytes, dask_worker: Worker) -> None:
    """Append to a file of the log, which is created if necessary. Raises :class:`OSError`."""
    log = _folder(dask_worker, ticket) / "log"
    path = log / name
    if not path.resolve().is_relative_to(log.resolve()):
        raise PermissionError("a file of a log is in the log’s folder")

    def append() -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("ab") as file:
            file.write(data)

    _renewed[ticket] = time.monotonic()
    await asyncio.to_thread(append)


async def renew_lease(ticket: str, dask_worker: Worker) -> float:
    """Let a job continue for another :data:`LEASE_S`; return its completed share, from 0 to 1."""
    _renewed[ticket] = time.monotonic()
    try:
        return float((_folder(dask_worker, ticket) / "lease").read_bytes() or 0.0)
    except (OSError, ValueError):
        return 0.0


async def end_job(ticket: str, dask_worker: Worker) -> None:
    """End a job, if it runs, and remove its files."""
    _renewed.pop(ticket, None)
    await _remove(_folder(dask_worker, ticket))


def map_sent_log(ticket: str, job: FleetJob, name: str) -> Mapped | Exception:
    """Do a job whose log was sent as ``name``, in its own process; return what the job raises.

    That is :class:`BrokenExecutor` if its process was killed. A raised exception is a fault of the cluster.
    """
    folder = _folder(get_worker(), ticket)
    out = folder / "out"
    here = replace(
        job,
        source=str(folder / "log" / name),
        map=None if job.map is None else str(out / Path(job.map).name),
        picture=str(out / Path(job.picture).name),
    )
    try:
        facts = do_in_process(here, str(folder / "lease"))
    except Exception as error:  # noqa: BLE001 - it crosses to the service
        return error
    return Mapped(facts, {path.name: path.read_bytes() for path in out.iterdir()})


def _folder(worker: Worker, ticket: str) -> Path:
    return Path(worker.local_directory) / f"{PREFIX}{ticket}"


async def _remove(folder: Path) -> None:
    """Remove the folder of a job. Its process, which may still be writing, ends without the lease."""
    (folder / "lease").unlink(missing_ok=True)
    await asyncio.to_thread(shutil.rmtree, folder, ignore_errors=True)


async def _expire(ticket: str, folder: Path) -> None:
    """End a job whose lease was not renewed."""
    while ticket in _renewed:
        left = _renewed[ticket] + LEASE_S - time.monotonic()
        if left <= 0.0:
            break
        await asyncio.sleep(left)
    _renewed.pop(ticket, None)
    await _remove(folder)
