"""The trajectories that visitors add to logs: files of TUM lines stored with the logs, and records in the database.

Only their owner sees them, even for logs that all visitors see. All methods run on the event loop; files are read and
written on threads.
"""

from __future__ import annotations

import asyncio
import contextlib
import gzip
import secrets
import time
import unicodedata
from collections import OrderedDict
from collections.abc import AsyncIterator, Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import structlog
from numpy.typing import NDArray

from mapper.core.errors import ConfigError, LimitError, MapperError
from mapper.core.limits import DEFAULT_LIMITS
from mapper.io.logs.summary import path_length
from mapper.localization.known import known_scans
from mapper.sensors.scan import ScanLog, Trajectory
from server.library.annotations.added import (
    Added,
    TrajectoryNotFoundError,
    TrajectorySource,
    delete_added,
    load_added,
    replace_added,
)
from server.library.logs.records import Record
from server.library.packs.filter_states import read_converged
from server.library.store.blobs import Blobs
from server.library.store.common_files import MIN_AGE_S
from server.library.store.database import Database
from server.storage import StorageError
from server.work.fair_lock import FairLock

FILES = "trajectories"  #: the folder of the store
TUM, GRAPH, FILTER_STATES = "tum", "graph", "course"  #: endings of its files
MAX_NAME = 80  #: characters of a name
MAX_OF_LOG = 20  #: trajectories that one visitor may add to a log
MAX_OF_OWNER = 200  #: and to all logs together
MAX_BYTES = 16 << 20  #: of one TUM file: 180,000 poses
BY_HAND = "; its graph was changed by hand"  #: ending of the description of such a trajectory
KEPT = 64  #: number of joined trajectories kept in memory

_log = structlog.get_logger(__name__)


@dataclass(frozen=True, slots=True)
class NewTrajectory:
    """A trajectory to add: its TUM ``text``, and files with the data from which it was computed.

    These are the pose ``graph`` of SLAM, or the ``filter_states`` of localization
    (:mod:`server.library.packs.filter_states`).
    """

    name: str
    text: bytes
    source: TrajectorySource = "tum"
    description: str = "the poses of an uploaded TUM file"
    graph: bytes | None = None
    filter_states: bytes | None = None

    @property
    def files(self) -> dict[str, bytes]:
        """The files besides the TUM file, by their endings."""
        both = {GRAPH: self.graph, FILTER_STATES: self.filter_states}
        return {ending: data for ending, data in both.items() if data is not None}


class Trajectories:
    """All added trajectories: records in memory and in ``database``, files in the store of ``blobs``."""

    def __init__(self, database: Database, blobs: Blobs, scratch: Path, room: Callable[[], int]) -> None:
        self._database = database
        self._files = blobs.beside(FILES)
        self._scratch = scratch
        self._room = room  #: returns the number of further bytes allowed
        self._added: dict[str, Added] = {}
        self._changing = asyncio.Lock()  #: held while a trajectory is added or removed
        self._reading = FairLock()  #: one file is read at a time
        self._joined: OrderedDict[tuple[str, int], tuple[NDArray[np.int64], Trajectory | None]] = OrderedDict()

    async def start(self, *, may_delete: bool) -> None:
        """Load the records and, if ``may_delete``, remove files that belong to none.

        Raises :class:`StorageError`.
        """
        await self.follow()
        if not may_delete:
            return
        with contextlib.suppress(StorageError):  # an unreachable bucket; the next start removes them
            for name in await self._files.names(MIN_AGE_S if self._database.is_shared else 0.0):
                if name.partition(".")[0] not in self._added:
                    await self._files.delete(name)

    async def follow(self, _: object = None) -> None:
        """Load the records. Raises :class:`StorageError`."""
        self._added = {trajectory.id: trajectory for trajectory in await self._database.run(load_added)}

    @property
    def total_bytes(self) -> int:
        """Bytes of all files."""
        return sum(trajectory.bytes for trajectory in self._added.values())

    def of(self, owner: str, log_id: str) -> Sequence[Added]:
        """Return the trajectories that ``owner`` has added to a log, oldest first."""
        return [
            trajectory
            for trajectory in self._added.values()
            if trajectory.owner == owner and trajectory.log_id == log_id
        ]

    def get(self, owner: str, log_id: str, name: str) -> Added:
        """Return one of them. Raises :class:`TrajectoryNotFoundError`."""
        for trajectory in self.of(owner, log_id):
            if trajectory.name == name:
                return trajectory
        raise TrajectoryNotFoundError("trajectory.not_found", f"You have added no trajectory {name!r:.90} to this log.")

    def check(self, owner: str, log_id: str, name: str, own_names: Sequence[str]) -> None:
        """Check that ``owner`` may add a trajectory of this name to a log that has ``own_names`` of its own.

        Raises :class:`ConfigError` for an invalid name or one of the log's own, :class:`LimitError` for too many
        trajectories.
        """
        is_clean = name == name.strip() and all(unicodedata.category(c)[0] != "C" for c in name)
        if not 0 < len(name) <= MAX_NAME or not is_clean or "/" in name:
            raise ConfigError(
                "trajectory.name",
                f"The name of a trajectory has 1 to {MAX_NAME} characters, no line breaks and no slash; {name!r:.90} "
                "is none.",
            )
        if name in own_names:
            raise ConfigError(
                "trajectory.name", f"The log has a trajectory {name!r:.90} of its own: choose another name."
            )
        known = self.of(owner, log_id)
        if any(trajectory.name == name for trajectory in known):
            return
        if len(known) >= MAX_OF_LOG:
            message = f"You have added {MAX_OF_LOG} trajectories to this log, the maximum: delete one."
            raise LimitError("trajectory.too_many", message)
        if sum(trajectory.owner == owner for trajectory in self._added.values()) >= MAX_OF_OWNER:
            message = f"You have added {MAX_OF_OWNER} trajectories to your logs, the maximum: delete one."
            raise LimitError("trajectory.too_many", message)

    async def put(self, owner: str, record: Record, log: ScanLog, new: NewTrajectory) -> tuple[Added, list[str]]:
        """Add a trajectory to ``log``, whose record is ``record``, or replace the owner's one of that name.

        Returns its record, and notes from reading it. Raises like :func:`mapper.io.trajectories.read_tum`,
        :func:`mapper.io.trajectories.poses_at_all_scans` and :meth:`check`, :class:`LimitError` if there is no room,
        and :class:`StorageError`; then nothing has changed.
        """
        beside = sum(map(len, new.files.values()))
        if self._room() < len(new.text) + beside:
            raise LimitError("library.full", "The server has no space left for logs; try again later.")
        own_names = [
            name for name in log.trajectories if name not in {added.name for added in self.of(owner, record.id)}
        ]
        self.check(owner, record.id, new.name, own_names)
        trajectory_id = secrets.token_hex(10)
        file = self._scratch / f"{trajectory_id}.tum"
        try:
            async with self._reading.of(owner):
                await asyncio.to_thread(_write_packed, file, new.text)
                count, trajectory, notes = await asyncio.to_thread(_read, file, log, new.description)
            added = Added(
                id=trajectory_id,
                owner=owner,
                log_id=record.id,
                name=new.name,
                description=new.description,
                source=new.source,
                created_s=time.time(),
                bytes=file.stat().st_size + beside,
                poses=count,
                length_m=path_length(trajectory.poses),
                has_graph=new.graph is not None,
            )
            async with self._changing:
                self.check(owner, record.id, new.name, own_names)
                await self._keep(record, added, file, new.files)
        finally:
            file.unlink(missing_ok=True)
        return added, notes

    async def _keep(self, record: Record, added: Added, file: Path, beside: dict[str, bytes]) -> None:
        """Store files and row, or neither; remove those of the replaced trajectory."""
        try:
            await self._files.move_in(file, f"{added.id}.tum")
            for ending, data in beside.items():
                other = file.with_suffix(f".{ending}")
                await asyncio.to_thread(other.write_bytes, data)
                await self._files.move_in(other, f"{added.id}.{ending}")
            await self._database.run(lambda connection: replace_added(connection, record, added))
        except BaseException:
            await self._remove_files(added.id)
            raise
        replaced = [trajectory.id for trajectory in self.of(added.owner, added.log_id) if trajectory.name == added.name]
        self._added[added.id] = added
        for added_id in replaced:
            del self._added[added_id]
            await self._remove_files(added_id)

    async def put_changed(
        self, owner: str, record: Record, log: ScanLog, name: str, text: bytes, graph: bytes
    ) -> Added:
        """Replace a trajectory after its graph was changed by hand. Raises like :meth:`get` and :meth:`put`."""
        known = self.get(owner, record.id, name)
        description = known.description.removesuffix(BY_HAND) + BY_HAND
        added, _ = await self.put(owner, record, log, NewTrajectory(name, text, known.source, description, graph))
        return added

    async def delete(self, owner: str, log_id: str, name: str) -> None:
        """Remove a trajectory. Sessions that use it continue.

        Raises :class:`TrajectoryNotFoundError` and :class:`StorageError`.
        """
        async with self._changing:
            added = self.get(owner, log_id, name)
            await self._database.run_deletion(lambda connection: delete_added(connection, owner, log_id, name))
            del self._added[added.id]
            await self._remove_files(added.id)

    async def forget_log(self, log_id: str) -> None:
        """Remove the trajectories of a log whose row, and theirs with it, was deleted."""
        for trajectory in [trajectory for trajectory in self._added.values() if trajectory.log_id == log_id]:
            self._added.pop(trajectory.id, None)
            await self._remove_files(trajectory.id)

    async def _remove_files(self, trajectory_id: str) -> None:
        for kind in (TUM, GRAPH, FILTER_STATES):
            await self._files.delete(f"{trajectory_id}.{kind}")

    async def text(self, owner: str, log_id: str, name: str) -> bytes:
        """Return the TUM lines of a trajectory. Raises :class:`TrajectoryNotFoundError` and :class:`StorageError`."""
        added = self.get(owner, log_id, name)
        async with self._files.file(f"{added.id}.tum") as path:
            return await asyncio.to_thread(lambda: gzip.decompress(_bytes_of(path)))

    async def graph(self, owner: str, log_id: str, name: str) -> bytes | None:
        """Return the file of a trajectory's pose graph, None if it has none. Raises like :meth:`text`."""
        added = self.get(owner, log_id, name)
        if not added.has_graph:
            return None
        async with self._files.file(f"{added.id}.{GRAPH}") as path:
            return await asyncio.to_thread(_bytes_of, path)

    async def filter_states(self, owner: str, log_id: str, name: str) -> bytes | None:
        """Return the file of a localization's filter states, None if it has none. Raises like :meth:`text`."""
        added = self.get(owner, log_id, name)
        if added.source != "localized":
            return None
        async with self._files.file(f"{added.id}.{FILTER_STATES}") as path:
            return await asyncio.to_thread(_bytes_of, path)

    async def joined(self, owner: str, log_id: str, log: ScanLog) -> ScanLog:
        """Return ``log`` with the trajectories that ``owner`` has added; it shares the readings.

        A trajectory that cannot be used with these scans, which may be another sensor's, is left out with a note.
        """
        extra: dict[str, Trajectory] = {}
        notes: list[str] = []
        for added in self.of(owner, log_id):
            if added.name in log.trajectories:
                continue
            trajectory = await self._at_scans(added, log)
            if trajectory is None:
                notes.append(f"The added trajectory {added.name!r} cannot be used with these scans.")
            else:
                extra[added.name] = trajectory
                notes += left_out(added.name, trajectory)
        if not extra and not notes:
            return log
        return replace(log, trajectories={**log.trajectories, **extra}, notes=(*log.notes, *notes))

    async def _at_scans(self, added: Added, log: ScanLog) -> Trajectory | None:
        key = (added.id, id(log.stamps_ns))
        joined = self._joined.get(key)
        if joined is not None:
            self._joined.move_to_end(key)
            return joined[1]
        trajectory: Trajectory | None = None
        try:
            async with self._reading.of(added.owner), self._files.file(f"{added.id}.tum") as path:
                _, read, _ = await asyncio.to_thread(_read, path, log, added.description)
            known = await self._known(added, log.n_scans) if added.source == "localized" else None
            trajectory = replace(read, from_scans=added.source != "tum", is_known=known)
        except MapperError as error:
            _log.warning("an added trajectory could not be joined", trajectory=added.id, code=error.code)
            if isinstance(error, StorageError):
                return None
        self._joined[key] = (log.stamps_ns, trajectory)  # with the stamps, so that their id is not reused
        if len(self._joined) > KEPT:
            self._joined.popitem(last=False)
        return trajectory

    async def _known(self, added: Added, n_scans: int) -> NDArray[np.bool_] | None:
        """Return at which scans (n,) the poses of a localization are known; None if all are, or for another sensor."""
        async with self._files.file(f"{added.id}.{FILTER_STATES}") as path:
            converged = await asyncio.to_thread(read_converged, path)
        known = known_scans(converged)
        return None if known.all() or len(known) != n_scans else known


async def text_of(chunks: AsyncIterator[bytes]) -> bytes:
    """Return the text that arrives in ``chunks``. Raises :class:`LimitError` if it exceeds :data:`MAX_BYTES`."""
    text = bytearray()
    async for piece in chunks:
        text += piece
        if len(text) > MAX_BYTES:
            raise LimitError("trajectory.too_large", f"A trajectory’s file has at most {MAX_BYTES >> 20} MiB here.")
    return bytes(text)


def left_out(name: str, trajectory: Trajectory) -> list[str]:
    """Return a note on the scans that maps along a trajectory omit because their poses are unknown."""
    known = trajectory.is_known
    if known is None:
        return []
    n = len(known) - int(np.count_nonzero(known))
    scans = "All scans" if n == len(known) else f"{n} of {len(known)} scans"
    return [f"{scans} are left out of maps along {name!r}: the filter had not converged there, so poses are not known."]


def _write_packed(path: Path, text: bytes) -> None:
    path.write_bytes(gzip.compress(text, 6, mtime=0))


def _bytes_of(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        message = "The file of this trajectory is no longer in the server’s store."
        raise StorageError("log.gone", message) from None


def _read(path: Path, log: ScanLog, description: str) -> tuple[int, Trajectory, list[str]]:
    """Return the number of poses in a TUM file, the trajectory at the scans of ``log``, and notes."""
    from mapper.io.trajectories import poses_at_all_scans, read_tum  # noqa: PLC0415 - imports the readers

    poses = read_tum(path, replace(DEFAULT_LIMITS, max_unpacked_bytes=MAX_BYTES, max_expansion=1))
    at_scans, notes = poses_at_all_scans(log, poses)
    return len(poses), Trajectory(at_scans, description, offset=poses.offset), [*poses.notes, *notes]
