"""The bytes of uploaded logs, stored through obstore in a folder or an S3 bucket, once for each SHA-256 digest.

An upload is written under a random name and moved to ``blobs/SHA-256`` when it is complete: by a rename in a folder, by
a copy on the server's side in a bucket. Incomplete files are never visible and are removed at the next start.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import shutil
import time
import uuid
from collections.abc import AsyncIterator, Collection, Iterator
from contextlib import asynccontextmanager, contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING

import obstore
import structlog
from obstore.exceptions import AlreadyExistsError, BaseError
from obstore.store import LocalStore, S3Store

from server.storage import StorageError, disk_full, private_folder

if TYPE_CHECKING:
    from obstore.store import ObjectStore, RetryConfig

BLOBS, INCOMING, IDENTITY = "blobs", "incoming", "identity"
LOCAL_PART_BYTES = 1 << 18  #: bytes of an upload that are buffered in memory
REMOTE_PART_BYTES = 5 << 20  #: the smallest part that S3 accepts
HASHED_AT_ONCE = 1 << 16  #: bytes that are hashed without another thread
PIECE_BYTES = 1 << 20
RETRY: RetryConfig = {"max_retries": 3, "retry_timeout": timedelta(seconds=30)}  #: of requests to S3

_log = structlog.get_logger(__name__)


class Incoming:
    """An upload being written to a store, ``size`` bytes so far. Event loop only, one call at a time."""

    def __init__(self, store: ObjectStore) -> None:
        self.name = uuid.uuid4().hex
        self.size = 0
        self._store = store
        self._digest = hashlib.sha256()
        part_bytes = LOCAL_PART_BYTES if isinstance(store, LocalStore) else REMOTE_PART_BYTES
        self._writer = obstore.open_writer_async(store, self._key, buffer_size=part_bytes)
        self._ended = False

    @property
    def _key(self) -> str:
        return f"{INCOMING}/{self.name}"

    @property
    def sha256(self) -> str:
        """Digest of the bytes so far."""
        return self._digest.hexdigest()

    async def write(self, data: bytes | bytearray) -> None:
        """Append ``data``, which must not be changed afterwards. Raises :class:`StorageError`."""
        if self._ended:
            return  # late data of a cancelled upload
        with _storage_errors(remote=not isinstance(self._store, LocalStore)):
            if len(data) <= HASHED_AT_ONCE:
                self._digest.update(data)
                await self._writer.write(data)
            else:
                hashing = asyncio.ensure_future(asyncio.to_thread(self._digest.update, data))
                try:
                    await self._writer.write(data)
                finally:
                    await hashing
        self.size += len(data)

    async def commit(self) -> None:
        """Move the bytes to their final name. If that fails they are removed, and :class:`StorageError` is raised."""
        try:
            with _storage_errors(remote=not isinstance(self._store, LocalStore)):
                await self._writer.close()
                await obstore.rename_async(self._store, self._key, f"{BLOBS}/{self.sha256}")
        except BaseException:
            await self.discard()
            raise
        self._ended = True

    async def discard(self) -> None:
        """Discard the bytes."""
        if self._ended:
            return
        self._ended = True
        writer, reason = self._writer, RuntimeError("the upload was given up")
        del self._writer  # which removes the written bytes, even if closing it failed
        with contextlib.suppress(OSError, BaseError):  # what cannot be removed now is removed at the next start
            if not await writer.closed():
                await writer.__aexit__(RuntimeError, reason, None)
        del writer
        with contextlib.suppress(OSError, BaseError):
            await obstore.delete_async(self._store, self._key)


class Blobs:
    """A store of blobs; ``folder`` is its place if that is a folder of this machine, ``scratch`` a folder for copies.

    ``kind`` is the folder of the store that contains the blobs.
    """

    def __init__(self, store: ObjectStore, folder: Path | None, scratch: Path, kind: str = BLOBS) -> None:
        self._store = store
        self._folder = folder
        self._scratch = scratch
        self._kind = kind

    @classmethod
    def at(cls, place: str | None, root: Path) -> Blobs:
        """Return the store at ``place``, a folder or ``s3://BUCKET/PREFIX``; None is the folder ``root``."""
        scratch = root / INCOMING
        if place is not None and place.startswith("s3://"):
            with _storage_errors(remote=True):
                return cls(S3Store.from_url(place, retry_config=RETRY), None, scratch)
        folder = root if place is None else Path(place)
        with _storage_errors(remote=False):
            for name in (BLOBS, INCOMING):
                private_folder(folder / name)
            return cls(LocalStore(prefix=folder), folder, scratch)

    def beside(self, kind: str) -> Blobs:
        """Return the files of another ``kind`` in the same store, with names chosen by their users."""
        if self._folder is not None:
            with _storage_errors(remote=False):
                private_folder(self._folder / kind)
        return Blobs(self._store, self._folder, self._scratch, kind)

    def identity(self) -> str:
        """Return the id of this store, which is created on the first call.

        Blocks. Raises :class:`StorageError`.
        """
        with _storage_errors(remote=not isinstance(self._store, LocalStore)):
            try:
                return bytes(obstore.get(self._store, IDENTITY).bytes()).decode("ascii", "replace")[:64]
            except FileNotFoundError:
                identity = uuid.uuid4().hex
                try:
                    obstore.put(self._store, IDENTITY, identity.encode(), mode="create")
                except AlreadyExistsError:  # another service has started at the same time
                    return bytes(obstore.get(self._store, IDENTITY).bytes()).decode("ascii", "replace")[:64]
                return identity

    def incoming(self) -> Incoming:
        """Return a new upload."""
        return Incoming(self._store)

    async def names(self, min_age_s: float = 0.0) -> set[str]:
        """Return the digests of all blobs at least ``min_age_s`` old. Raises :class:`StorageError`."""
        return {path.rsplit("/", 1)[-1] for path in await self._paths(self._kind, min_age_s)}

    async def _paths(self, kind: str, min_age_s: float) -> list[str]:
        newest = datetime.now(UTC) - timedelta(seconds=min_age_s)
        with _storage_errors(remote=not isinstance(self._store, LocalStore)):
            return [
                entry["path"]
                async for entries in obstore.list(self._store, kind)
                for entry in entries
                if not min_age_s or entry["last_modified"] < newest
            ]

    async def delete(self, name: str) -> None:
        """Remove a blob. A missing one is no error; one that cannot be removed is removed at the next start."""
        try:
            await obstore.delete_async(self._store, f"{self._kind}/{name}")
        except FileNotFoundError:
            pass
        except (OSError, BaseError) as error:
            _log.warning("a blob could not be removed", blob=name, error=str(error).partition("\n")[0])

    @asynccontextmanager
    async def file(self, name: str) -> AsyncIterator[Path]:
        """Yield a path at which a blob can be read: of the blob in a folder, of a copy otherwise."""
        if self._folder is not None:
            yield self._folder / self._kind / name
            return
        copy = self._scratch / f"{uuid.uuid4().hex}.copy"
        try:
            with _storage_errors(remote=not isinstance(self._store, LocalStore)):
                await self._copy(name, copy)
            yield copy
        finally:
            copy.unlink(missing_ok=True)

    async def _copy(self, name: str, path: Path) -> None:
        try:
            answer = await obstore.get_async(self._store, f"{self._kind}/{name}")
        except FileNotFoundError:
            raise StorageError("log.gone", "The bytes of this log are no longer in the server’s store.") from None
        with path.open("xb") as file:
            async for piece in answer.stream(PIECE_BYTES):
                await asyncio.to_thread(file.write, piece)

    async def move_in(self, path: Path, name: str) -> None:
        """Move a local file into the store. Raises :class:`StorageError`."""
        with _storage_errors(remote=not isinstance(self._store, LocalStore)):
            if self._folder is not None:
                await asyncio.to_thread(path.replace, self._folder / self._kind / name)
                return
            await obstore.put_async(self._store, f"{self._kind}/{name}", path)
            await asyncio.to_thread(path.unlink)

    async def copy_in(self, path: Path, name: str) -> None:
        """Copy a local file into the store. Raises :class:`StorageError`."""
        with _storage_errors(remote=not isinstance(self._store, LocalStore)):
            await obstore.put_async(self._store, f"{self._kind}/{name}", path)

    async def copy_out(self, name: str, path: Path) -> None:
        """Copy a blob to a new local file, completely or not at all. Raises :class:`StorageError`, also if missing."""
        copy = path.with_name(f"{path.name}.{uuid.uuid4().hex}.new")
        try:
            with _storage_errors(remote=not isinstance(self._store, LocalStore)):
                await self._copy(name, copy)
                copy.replace(path)
        finally:
            copy.unlink(missing_ok=True)

    async def remove_unreferenced(self, keep: Collection[str], min_age_s: float = 0.0) -> None:
        """Remove incomplete files of an earlier run, and all blobs except those named in ``keep``.

        If other services use the store, ``min_age_s`` spares files that they may be writing.
        """
        for name in await self.names(min_age_s) - set(keep):
            await self.delete(name)
        paths = await self._paths(INCOMING, min_age_s)
        with _storage_errors(remote=not isinstance(self._store, LocalStore)):
            if paths:
                await obstore.delete_async(self._store, paths)
        await asyncio.to_thread(_empty, self._scratch, 0.0)
        if self._folder is not None and self._folder / INCOMING != self._scratch:
            await asyncio.to_thread(_empty, self._folder / INCOMING, min_age_s)


def _empty(folder: Path, min_age_s: float) -> None:
    for path in folder.iterdir():  # obstore does not list the parts of an upload
        with contextlib.suppress(FileNotFoundError):
            if min_age_s and path.stat().st_mtime >= time.time() - min_age_s:
                continue
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink()


@contextmanager
def _storage_errors(*, remote: bool) -> Iterator[None]:
    """Convert errors of a store to :class:`StorageError` and log the cause; ``remote`` is False for a folder."""
    try:
        yield
    except (OSError, BaseError) as error:
        _log.warning("the store of blobs failed", error=str(error).partition("\n")[0])
        if remote:
            message = "The server cannot reach its store of logs just now; try again later."
            raise StorageError("log.store", message) from error
        raise disk_full() from error
