"""The maps in which visitors' logs are localized: one for each visitor and log, created in a process with limits.

Services with a shared store get the newest of each from it.
"""

from __future__ import annotations

import asyncio
import hashlib
import secrets
import shutil
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from mapper.core.errors import LimitError, ReadError
from mapper.io import maps
from mapper.mapping.parameters import BY_NAME, MappingConfig, recorded_defaults
from server.jobs import process
from server.jobs.outcome import outcome_of
from server.jobs.process import BoundedJob, JobLimits
from server.jobs.workers import Worker
from server.library.packs.log import log_in
from server.library.packs.map_files import MOST_BYTES, read_map
from server.library.packs.reference_map import ReferenceMap, read_reference_map
from server.library.processing.log_jobs import Logs, packed
from server.library.store.common_files import CommonFiles
from server.storage import private_folder
from server.work.fair_lock import FairLock

LIMITS = JobLimits(timeout_s=300.0, cpu_s=600.0)
RESOLUTIONS = (0.05, 0.1, 0.2, 0.5)  #: metres per cell: the first that the limits allow
MOST_CELLS = 1 << 26


@dataclass(frozen=True, slots=True)
class ReferenceMapJob(BoundedJob[ReferenceMap]):
    """Create the map ``title`` in the file ``out``.

    ``source`` is the pack of a log, mapped along its ``trajectory``; or, if that is None, the map files: a tar archive
    of a yaml and its image, or a map of CMU's course.
    """

    DOING = "Making this map"
    CODE = "map"

    source: str
    out: str
    title: str
    trajectory: str | None
    limits: JobLimits

    def compute(self) -> ReferenceMap:
        """Return the map. Raises :class:`mapper.core.errors.MapperError` for a file that is not a map."""
        reference = (
            read_map(Path(self.source), self.title, Path(self.out).parent)
            if self.trajectory is None
            else _of_log(self, self.trajectory)
        )
        if reference.values.size > MOST_CELLS:
            raise LimitError(
                "map.cells", f"The map has {reference.values.size:,} cells; at most {MOST_CELLS:,} are used here."
            )
        if not (reference.values >= 0).any():
            raise ReadError("map.empty", "The map has no known cells: nothing can be localized in it.")
        reference.write(Path(self.out))
        process.note_progress(1.0)
        return reference


def _of_log(job: ReferenceMapJob, trajectory: str) -> ReferenceMap:
    from mapper.mapping.integrate import grid_for, integrate_log  # noqa: PLC0415

    log = log_in(job.source)
    row = BY_NAME["range_max"]
    reach = min(max(min(log.range_max, row.initial), row.low), row.high)
    config = MappingConfig().with_values(recorded_defaults(log.beam_width, {"range_max": reach}))
    for resolution in RESOLUTIONS:
        config = config.with_values({"resolution": resolution})
        try:
            grid = grid_for(log, config, trajectory)
        except LimitError:
            if resolution == RESOLUTIONS[-1]:
                raise
            continue
        if grid.log_odds.size <= MOST_CELLS:
            break
    integrate_log(grid, log, config, trajectory)
    return ReferenceMap(job.title, grid.geometry, maps.occupancy_values(grid))


class MapLogs(Logs, Protocol):
    """Interface of the library that is used here."""

    async def reference_map(self, owner: str, log_id: str) -> ReferenceMap | None:
        """Return a map of the library, None for a log."""


class ReferenceMaps:
    """All maps, as files in ``folder`` and in the store of ``common``. Used from the event loop only."""

    def __init__(
        self, logs: MapLogs, worker: Callable[[], Worker], folder: Path, room: Callable[[], int], common: CommonFiles
    ) -> None:
        self._logs, self._make_worker, self._folder, self._room, self._common = logs, worker, folder, room, common
        self._worker: Worker | None = None
        self._turns = FairLock()
        private_folder(folder)
        for left in folder.iterdir():  # by a killed process
            if left.is_dir() and not left.is_symlink():
                shutil.rmtree(left, ignore_errors=True)
            elif left.suffix != ".npz":
                left.unlink(missing_ok=True)
        self._bytes = sum(file.stat().st_size for file in folder.glob("*.npz"))

    @property
    def total_bytes(self) -> int:
        """Bytes of all files."""
        return self._bytes

    def path(self, owner: str, log_id: str) -> Path:
        """Return the path of the map chosen by a visitor for a log; it may not exist."""
        name = hashlib.sha256(f"{log_id}\n{owner}".encode()).hexdigest()[:40]
        return self._folder / f"{hashlib.sha256(log_id.encode()).hexdigest()[:16]}-{name}.npz"

    async def get(self, owner: str, log_id: str) -> ReferenceMap:
        """Return that map. Raises :class:`ConfigError` if there is none."""
        self._logs.get(owner, log_id)
        return await asyncio.to_thread(read_reference_map, await self.newest(owner, log_id))

    async def newest(self, owner: str, log_id: str) -> Path:
        """Return :meth:`path` after updating it with the newest map, which another service may have chosen."""
        path = self.path(owner, log_id)
        before = _bytes_of(path)
        await self._common.update(path, _common_name(log_id, path))
        self._bytes += _bytes_of(path) - before
        return path

    async def of_log(
        self, owner: str, log_id: str, other: str, topic: str | None, trajectory: str | None, *, address: str = ""
    ) -> ReferenceMap:
        """Choose the map of the log ``other`` along a trajectory (None: its first), or ``other`` itself if it is a map.

        Raises :class:`LimitError`, and like the library for logs that the owner may not open.
        """
        self._logs.get(owner, log_id)
        reference = await self._logs.reference_map(owner, other)
        if reference is not None:
            return await self._keep(owner, log_id, reference)
        log = await self._logs.load(owner, other, topic)
        name = trajectory or log.default_trajectory
        log.trajectory(name)
        title = f"{self._logs.get(owner, other).name}, {name}"
        source = self._folder / f"{secrets.token_hex(10)}.pack"
        try:
            await asyncio.to_thread(packed, log, source)
            return await self._made(owner, address, log_id, source, title, name)
        finally:
            await asyncio.to_thread(source.unlink, missing_ok=True)

    async def of_files(
        self, owner: str, log_id: str, title: str, chunks: AsyncIterator[bytes], *, address: str = ""
    ) -> ReferenceMap:
        """Choose the map in uploaded files, see :class:`ReferenceMapJob`.

        Raises :class:`LimitError` and :class:`mapper.core.errors.ReadError`.
        """
        self._logs.get(owner, log_id)
        source = self._folder / f"{secrets.token_hex(10)}.upload"
        try:
            size = 0
            with source.open("wb") as file:
                async for chunk in chunks:
                    size += len(chunk)
                    if size > min(MOST_BYTES, self._room()):
                        raise LimitError("map.too_large", f"Map files have at most {MOST_BYTES >> 20} MiB here.")
                    await asyncio.to_thread(file.write, chunk)
            return await self._made(owner, address, log_id, source, title, None)
        finally:
            await asyncio.to_thread(source.unlink, missing_ok=True)

    async def _made(
        self, owner: str, address: str, log_id: str, source: Path, title: str, trajectory: str | None
    ) -> ReferenceMap:
        fresh = self._folder / f"{secrets.token_hex(10)}.new"
        job = ReferenceMapJob(str(source), str(fresh), title, trajectory, LIMITS)
        try:
            async with self._turns.of(owner, address):
                worker = self._worker = self._worker or self._make_worker()
                reference = await outcome_of(worker, job)
            await self._put(owner, log_id, fresh)
            return reference
        finally:
            await asyncio.to_thread(fresh.unlink, missing_ok=True)

    async def _keep(self, owner: str, log_id: str, reference: ReferenceMap) -> ReferenceMap:
        """Choose a map of the library."""
        fresh = self._folder / f"{secrets.token_hex(10)}.new"
        try:
            await asyncio.to_thread(reference.write, fresh)
            await self._put(owner, log_id, fresh)
        finally:
            await asyncio.to_thread(fresh.unlink, missing_ok=True)
        return reference

    async def _put(self, owner: str, log_id: str, fresh: Path) -> None:
        """Store the file ``fresh`` as the chosen map, here and in the store."""
        self._logs.get(owner, log_id)  # it may have been deleted in the meantime
        out = self.path(owner, log_id)
        self._replace(fresh, out)
        await self._common.replace(out, _common_name(log_id, out))

    def _replace(self, fresh: Path, out: Path) -> None:
        """Replace the file ``out`` by a new one."""
        size = _bytes_of(fresh)
        if size > self._room():
            raise LimitError("library.full", "The server has no space left for logs; try again later.")
        self._bytes += size - _bytes_of(out)
        fresh.replace(out)

    async def forget_log(self, log_id: str) -> None:
        """Remove the maps chosen for a log."""
        for file in self._folder.glob(f"{hashlib.sha256(log_id.encode()).hexdigest()[:16]}-*.npz"):
            self._bytes -= _bytes_of(file)
            file.unlink(missing_ok=True)
            await self._common.delete(_common_name(log_id, file))

    async def close(self) -> None:
        """End the process."""
        if self._worker is not None:
            await asyncio.to_thread(self._worker.close)


def _common_name(log_id: str, path: Path) -> str:
    """Return the name of a map in the store, where the names of a log's files begin with its id."""
    return f"{log_id}.{path.name}"


def _bytes_of(path: Path) -> int:
    """Return the size of a file, 0 if there is none."""
    try:
        return path.stat().st_size
    except FileNotFoundError:
        return 0
