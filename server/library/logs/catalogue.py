"""The catalogue: all records in memory, each with its row, blob and pack. Deleting a record deletes all of them.

All methods run on the event loop. Identical uploads of several visitors share one blob, which is deleted with the last
of them.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Collection, Sequence
from collections.abc import Set as AbstractSet
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import replace
from pathlib import Path

import structlog

from server.jobs.leases import Lease
from server.library.logs.cache import LogCache
from server.library.logs.folder import FolderLog
from server.library.logs.records import Record, Records
from server.library.store.blobs import Blobs, Incoming
from server.library.store.common_files import CommonFiles
from server.storage import StorageError

_log = structlog.get_logger(__name__)

INTERRUPTED = "log.interrupted"  #: code of the error of a log whose reading was interrupted too often
UNSTORED = "log.storage"  #: code of the error of a log for which the disk had no room
FULL_BYTES = 1 << 20  #: free space below which a file system counts as full


class Catalogue:
    """The records of one library, stored in ``store``; ``root`` is the folder of its packs and pictures.

    ``forgotten`` is called with the id of each log whose record was removed; ``common`` has the files that several
    services share.
    """

    def __init__(
        self,
        store: Records,
        blobs: Blobs,
        cache: LogCache,
        root: Path,
        common: CommonFiles,
        forgotten: Callable[[str], Awaitable[None]] | None = None,
    ) -> None:
        self._store = store
        self._blobs = blobs
        self._cache = cache
        self._common = common
        self._forgotten = forgotten
        self._root = root
        self._packs = root / "packs"
        self._pictures = root / "pictures"
        self._records: dict[str, Record] = {}  #: uploads, and logs of the folder that were or will be read
        self._blob_lock = asyncio.Lock()  #: held while a blob is added or deleted
        self.folder_logs: dict[str, FolderLog] = {}

    async def start(self, *, stores_match: bool = True) -> None:
        """Load the records of an earlier run and remove its unfinished files. Raises ``StorageError``.

        Unless ``stores_match`` (the blobs belong to these records), no record and no blob is removed.
        """
        records = await self._store.load()
        there: set[str] = set()
        try:
            there = await self._blobs.names()
        except StorageError:  # an unreachable bucket must not cause the deletion of records
            stores_match = False
        for record in records:
            if record.source == "sample":  # it has a row only if there is a link to it
                continue
            if record.source == "folder":
                is_gone = record.id not in self.folder_logs
            else:
                is_gone = stores_match and record.sha256 not in there
            if is_gone:
                await self._store.delete(record.id)
            else:
                self._records[record.id] = record
        if stores_match:
            await self._remove_unreferenced_blobs(is_new=not records)
        await asyncio.to_thread(self._remove_unreferenced_packs)

    async def _remove_unreferenced_blobs(self, *, is_new: bool) -> None:
        """Remove incomplete uploads, and blobs that belong to no record."""
        try:
            names = await self._blobs.names()
            if is_new and names:  # they may belong to another database
                _log.warning("the database knows none of the blobs: they are left alone", blobs=len(names))
            keep = names if is_new else {record.sha256 for record in self.uploaded()}
            await self._blobs.remove_unreferenced(keep, self._common.min_age_s)
            if not is_new:
                await self._common.remove_unreferenced(self._records)
        except StorageError:
            _log.warning("the store of blobs could not be tidied")

    def _remove_unreferenced_packs(self) -> None:
        """Remove incomplete packs and pictures, and those that belong to no record."""
        for path in (*self._packs.iterdir(), *self._pictures.iterdir()):
            log_id = path.name.partition(".")[0]
            if path.suffix not in (".npz", ".png") or not (log_id in self._records or log_id in self.folder_logs):
                path.unlink(missing_ok=True)

    # -- queries ------------------------------------------------------------------------------------------------

    def get(self, log_id: str) -> Record | None:
        """Return a record, None if there is none."""
        return self._records.get(log_id)

    def all(self) -> Sequence[Record]:
        """Return all records."""
        return list(self._records.values())

    def uploaded(self) -> Sequence[Record]:
        """Return the records of uploads."""
        return [record for record in self._records.values() if record.source == "upload"]

    def interrupted(self) -> Sequence[Record]:
        """Return the uploads, oldest first, whose reading an earlier run did not finish, or had no disk space for."""
        return [
            record
            for record in self.uploaded()
            if record.state in ("queued", "reading") or (record.error and record.error.code in (INTERRUPTED, UNSTORED))
        ]

    @property
    def bytes(self) -> int:
        """Bytes of all uploads, each counted once, and of the data read from them."""
        uploads = self.uploaded()
        return sum({upload.sha256: upload.bytes for upload in uploads}.values()) + sum(
            upload.packed_bytes for upload in uploads
        )

    def pack(self, log_id: str) -> Path:
        """Return the path of the pack of a log."""
        return self._packs / f"{log_id}.npz"

    def contents(self, log_id: str) -> Path:
        """Return the path of the contents of a log's recording; it may not exist yet."""
        return self._packs / f"{log_id}.contents.npz"

    def picture(self, log_id: str) -> Path:
        """Return the path of the picture of a log's map; it may not exist yet."""
        return self._pictures / f"{log_id}.png"

    def pictured(self) -> AbstractSet[str]:
        """Return the ids of all logs of which there is a picture; reads a folder, which is for a thread."""
        return {path.stem for path in self._pictures.iterdir() if path.suffix == ".png"}

    def source(self, record: Record) -> AbstractAsyncContextManager[Path]:
        """Yield the path at which a log's file can be read."""
        return self._folder_file(record) if record.source == "folder" else self._blobs.file(record.sha256)

    @asynccontextmanager
    async def _folder_file(self, record: Record) -> AsyncIterator[Path]:
        yield self.folder_logs[record.id].path

    async def fetch(self, log_id: str) -> None:
        """Copy the pack and the picture of a log that another service has read, if they are missing here."""
        await self._common.fetch(self.pack(log_id), self.picture(log_id))

    async def publish(self, log_id: str) -> None:
        """Copy the pack and the picture of a log to the place where other services find them."""
        await self._common.publish(self.pack(log_id), self.picture(log_id))

    # -- changing -----------------------------------------------------------------------------------------------

    async def add(self, record: Record, incoming: Incoming) -> Record:
        """Store a new upload and its bytes; return the record of the same bytes and owner if there is one.

        Raises ``StorageError``; then nothing of it is stored.
        """
        async with self._blob_lock, self._common.alone(record.sha256):
            for known in self.uploaded():
                if known.owner == record.owner and known.sha256 == record.sha256:
                    return known
            await incoming.commit()
            try:
                await self._store.put(record)
            except BaseException:
                await self._delete_unused_blob(record.sha256)
                raise
            self._records[record.id] = record
        return record

    def save(self, record: Record) -> None:
        """Store a changed record, unless it is of a deleted upload, whose bytes are gone.

        If it cannot be written, the change is lost at the next start.
        """
        if record.source == "upload" and record.id not in self._records:
            return
        self._records[record.id] = record
        # For the folder's logs only expensive results are stored; everything else is read again.
        if record.source == "upload" or record.state == "ready":
            asyncio.ensure_future(self._store.change(record)).add_done_callback(_ignore_error)

    async def finish(self, record: Record, lease: Lease) -> None:
        """Store the result of a job, unless the log was deleted, and release the job's lease.

        If it cannot be written, the change is lost at the next start. Raises :class:`LeaseLostError`.
        """
        if not self._common.is_shared:
            self.save(record)
            return
        with contextlib.suppress(StorageError):
            await lease.finish(self._store.writing(record))
        if record.id in self._records:
            self._records[record.id] = record

    async def is_due(self, log_id: str) -> bool:
        """Return whether a log must be read, according to the database."""
        records = await self._store.get([log_id])
        if not records:
            return log_id in self.folder_logs
        self._records[log_id] = records[0]
        return records[0].state in ("queued", "reading")

    async def follow(self, log_ids: Collection[str] | None) -> list[Record]:
        """Load the changes of another service for some logs, None: for any; return their records.

        Raises ``StorageError``.
        """
        records = await (self._store.load() if log_ids is None else self._store.get(log_ids))
        records = [record for record in records if record.source == "upload" or record.id in self.folder_logs]
        there = {record.id for record in records}
        for log_id in [record.id for record in self.uploaded()] if log_ids is None else log_ids:
            if log_id not in there and log_id in self._records:
                await self._forget(log_id)
        self._records |= {record.id: record for record in records}
        return records

    async def delete(self, log_id: str) -> None:
        """Remove a log's record, pack and, unless another record shares it, blob. Raises ``StorageError``."""
        record = self._records.get(log_id)
        sha256 = record.sha256 if record is not None and record.source == "upload" else None
        async with self._blob_lock, self._common.alone(sha256):
            try:
                await self._store.delete(log_id)
            except StorageError:
                if not _is_full(self._packs):
                    raise
                # On a full disk the database cannot even delete, so removing the log's derived files makes room.
                self._remove_derived(log_id)
                await self._store.delete(log_id)
            self._records.pop(log_id, None)
            await self._common.delete(self.pack(log_id).name, self.picture(log_id).name)
            if sha256 is not None:
                await self._delete_unused_blob(sha256)
        await self._forget(log_id)

    async def _forget(self, log_id: str) -> None:
        """Remove the local data of a log whose record was deleted."""
        self._records.pop(log_id, None)
        self._cache.drop(log_id)  # its other sensors' scans follow when they are the least recently used
        self._remove_derived(log_id)
        if self._forgotten is not None:
            await self._forgotten(log_id)

    def _remove_derived(self, log_id: str) -> None:
        """Remove the files of a log that are derived from its bytes."""
        for path in (self.pack(log_id), self.contents(log_id), self.picture(log_id)):
            path.unlink(missing_ok=True)

    async def expire(self, oldest_s: float, busy: Sequence[str]) -> None:
        """Remove the uploads that were last used before ``oldest_s``, except those that are ``busy``."""
        for record in self.uploaded():
            if record.used_s < oldest_s and record.id not in busy:
                with contextlib.suppress(StorageError):  # next time
                    await self.delete(record.id)

    def mark_used(self, record: Record) -> Record:
        """Record that an upload is in use."""
        record = replace(record, used_s=time.time())
        self._records[record.id] = record
        asyncio.ensure_future(self._store.mark_used(record)).add_done_callback(_ignore_error)
        return record

    async def _delete_unused_blob(self, sha256: str) -> None:
        if any(record.sha256 == sha256 for record in self.uploaded()):
            return
        if not (self._common.is_shared and await self._store.is_stored(sha256)):
            await self._blobs.delete(sha256)


def _is_full(folder: Path) -> bool:
    """Return whether the file system of a folder has so little room that a database may not be able to write."""
    try:
        room = os.statvfs(folder)
    except OSError:
        return False
    return room.f_bavail * room.f_frsize < FULL_BYTES


def _ignore_error(written: asyncio.Future[None]) -> None:
    if not written.cancelled():
        written.exception()  # it is already logged, and a full disk must not stop the use of a log in memory
