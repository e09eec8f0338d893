"""The bytes of uploaded logs, through obstore: a folder, or a bucket of S3. Each file is kept once, by its digest.

An upload is written under a random name and moved to ``blobs/SHA-256`` when it is complete: by a rename in a folder, by
a copy on the server's side in a bucket. Incomplete files are never visible and are removed at the next start.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import uuid
from collections.abc import AsyncIterator, Collection, Iterator
from contextlib import asynccontextmanager, contextmanager
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING

import obstore
import structlog
from obstore.exceptions import BaseError
from obstore.store import LocalStore, S3Store

from server.library.storage import StorageError, disk_full, private_folder

if TYPE_CHECKING:
    from obstore.store import ObjectStore, RetryConfig

BLOBS, INCOMING, IDENTITY = "blobs", "incoming", "identity"
LOCAL_PART_BYTES = 1 << 18  #: bytes of an upload that are held back in memory
REMOTE_PART_BYTES = 5 << 20  #: S3 takes no smaller parts
HASHED_AT_ONCE = 1 << 16  #: bytes that are not worth another thread
PIECE_BYTES = 1 << 20
RETRY: RetryConfig = {"max_retries": 3, "retry_timeout": timedelta(seconds=30)}  #: what S3 did not answer

_log = structlog.get_logger(__name__)


class Incoming:
    """An upload that is being written to a store, ``size`` bytes so far. Event loop only, one call at a time."""

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
            return  # late data of an upload that was cancelled
        with _told(away=not isinstance(self._store, LocalStore)):
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

    async def place(self) -> None:
        """Move the bytes to their final name. Raises :class:`StorageError`; then they are removed."""
        try:
            with _told(away=not isinstance(self._store, LocalStore)):
                await self._writer.close()
                await obstore.rename_async(self._store, self._key, f"{BLOBS}/{self.sha256}")
        except BaseException:
            await self.drop()
            raise
        self._ended = True

    async def drop(self) -> None:
        """Discard the bytes."""
        if self._ended:
            return
        self._ended = True
        writer, reason = self._writer, RuntimeError("the upload was given up")
        del self._writer  # with it goes what it has written, also where closing it failed
        with contextlib.suppress(OSError, BaseError):  # what cannot be removed now is removed at the next start
            if not await writer.closed():
                await writer.__aexit__(RuntimeError, reason, None)
        del writer
        with contextlib.suppress(OSError, BaseError):
            await obstore.delete_async(self._store, self._key)


class Blobs:
    """A store of blobs; ``folder`` is where it is if that is a folder of this machine, ``scratch`` one for copies.

    ``kind`` is the folder of the store in which the blobs are.
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
            with _told(away=True):
                return cls(S3Store.from_url(place, retry_config=RETRY), None, scratch)
        folder = root if place is None else Path(place)
        with _told(away=False):
            for name in (BLOBS, INCOMING):
                private_folder(folder / name)
            return cls(LocalStore(prefix=folder), folder, scratch)

    def beside(self, kind: str) -> Blobs:
        """Return the files of another ``kind`` in the same store, whose names their users choose."""
        if self._folder is not None:
            with _told(away=False):
                private_folder(self._folder / kind)
        return Blobs(self._store, self._folder, self._scratch, kind)

    def identity(self) -> str:
        """Return the id of this store, which is created on the first call.

        Blocks. Raises :class:`StorageError`.
        """
        with _told(away=not isinstance(self._store, LocalStore)):
            try:
                return bytes(obstore.get(self._store, IDENTITY).bytes()).decode("ascii", "replace")[:64]
            except FileNotFoundError:
                identity = uuid.uuid4().hex
                obstore.put(self._store, IDENTITY, identity.encode())
                return identity

    def incoming(self) -> Incoming:
        """Return a new upload."""
        return Incoming(self._store)

    async def names(self) -> set[str]:
        """Return the digests of all blobs. Raises :class:`StorageError`."""
        found: set[str] = set()
        with _told(away=not isinstance(self._store, LocalStore)):
            async for entries in obstore.list(self._store, self._kind):
                found |= {entry["path"].rsplit("/", 1)[-1] for entry in entries}
        return found

    async def delete(self, name: str) -> None:
        """Remove a blob; one that is not there is no error, and one that stays is removed at the next start."""
        try:
            await obstore.delete_async(self._store, f"{self._kind}/{name}")
        except FileNotFoundError:
            pass
        except (OSError, BaseError) as error:
            _log.warning("a blob could not be removed", blob=name, error=str(error).partition("\n")[0])

    @asynccontextmanager
    async def file(self, name: str) -> AsyncIterator[Path]:
        """Yield a path at which a blob can be read: its own in a folder, that of a copy otherwise."""
        if self._folder is not None:
            yield self._folder / self._kind / name
            return
        copy = self._scratch / f"{uuid.uuid4().hex}.copy"
        try:
            with _told(away=not isinstance(self._store, LocalStore)):
                await self._copy(name, copy)
            yield copy
        finally:
            copy.unlink(missing_ok=True)

    async def _copy(self, name: str, path: Path) -> None:
        try:
            answer = await obstore.get_async(self._store, f"{self._kind}/{name}")
        except FileNotFoundError:
            raise StorageError("log.gone", "The bytes of this log are no longer in the server's store.") from None
        with path.open("xb") as file:
            async for piece in answer.stream(PIECE_BYTES):
                await asyncio.to_thread(file.write, piece)

    async def take(self, path: Path, name: str) -> None:
        """Move a file of this machine into the store. Raises :class:`StorageError`."""
        with _told(away=not isinstance(self._store, LocalStore)):
            if self._folder is not None:
                await asyncio.to_thread(path.replace, self._folder / self._kind / name)
                return
            await obstore.put_async(self._store, f"{self._kind}/{name}", path)
            await asyncio.to_thread(path.unlink)

    async def sweep(self, keep: Collection[str]) -> None:
        """Remove incomplete files of an earlier run, and the blobs that are not among ``keep``."""
        for name in await self.names() - set(keep):
            await self.delete(name)
        with _told(away=not isinstance(self._store, LocalStore)):
            async for entries in obstore.list(self._store, INCOMING):
                await obstore.delete_async(self._store, [entry["path"] for entry in entries])
        folders = {self._scratch} if self._folder is None else {self._scratch, self._folder / INCOMING}
        for folder in folders:
            await asyncio.to_thread(_empty, folder)


def _empty(folder: Path) -> None:
    for path in folder.iterdir():  # not by obstore: it does not list the parts of an upload
        path.unlink(missing_ok=True)


@contextmanager
def _told(*, away: bool) -> Iterator[None]:
    """Raise a store's error as one sentence, ``away`` for a remote store; the cause goes to the service's log."""
    try:
        yield
    except (OSError, BaseError) as error:
        _log.warning("the store of blobs failed", error=str(error).partition("\n")[0])
        if away:
            message = "The server cannot reach its store of logs just now; try again later."
            raise StorageError("log.store", message) from error
        raise disk_full() from error
