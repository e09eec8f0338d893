"""Receives uploads into the store of blobs, atomically, counting and digesting them.

An upload with a key, chosen by the sender, may come in parts: data before an interruption is kept for a while, and the
next part continues it. One without a key is discarded when it is interrupted.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field

from mapper.core.errors import LimitError, MapperError, ReadError
from server.library.store.blobs import Blobs, Incoming
from server.storage import StorageError

BATCH_BYTES = 1 << 20  #: bytes written to the store at a time
RESUMED = ("log.stalled", "library.busy")  #: errors after which the sender may continue the upload
KEEP_PARTIAL_S = 3600.0  #: seconds after its last byte at which an interrupted upload is discarded
MAX_PARTIALS_PER_OWNER = 4
MAX_PARTIALS = 64


class UploadOffsetError(MapperError):
    """The part does not begin where the received bytes end, or the same upload is already being received."""


@dataclass(frozen=True, slots=True)
class Part:
    """Part of an upload: ``key`` names the upload, the part begins at byte ``start`` of ``total``."""

    key: str
    start: int
    total: int


@dataclass(slots=True)
class Received:
    """An upload being received, of ``total`` bytes if that is known."""

    incoming: Incoming
    total: int | None = None
    busy: bool = False
    is_given_up: bool = False
    touched_s: float = field(default_factory=time.monotonic)

    @property
    def size(self) -> int:
        """Number of bytes received so far."""
        return self.incoming.size

    async def write(self, data: bytes | bytearray) -> None:
        """Append ``data``. Once started it completes, even if the caller is cancelled."""
        job = asyncio.ensure_future(self.incoming.write(data))
        try:
            await asyncio.shield(job)
        except asyncio.CancelledError:
            await asyncio.wait([job])
            raise
        self.touched_s = time.monotonic()


class UploadReceiver:
    """The uploads that are running, or were interrupted and may be continued. Used from the event loop only."""

    def __init__(self, blobs: Blobs, *, max_bytes: int) -> None:
        self._blobs = blobs
        self._max_bytes = max_bytes
        self._partial: dict[tuple[str, str], Received] = {}  #: by owner and key
        self._leaving: set[asyncio.Task[None]] = set()

    @property
    def reserved(self) -> int:
        """Disk space reserved for uploads that may continue, bytes."""
        return sum(upload.size for upload in self._partial.values())

    def offset(self, owner: str, key: str) -> int:
        """Return the number of received bytes of an upload; 0 for an unknown one."""
        self._forget_old()
        known = self._partial.get((owner, key))
        return 0 if known is None else known.size

    def forget(self, owner: str, key: str) -> None:
        """Discard an upload, immediately or at the end of the part being received."""
        known = self._partial.get((owner, key))
        if known is not None and known.busy:
            known.is_given_up = True
        elif known is not None:
            self._forget((owner, key))

    async def close(self) -> None:
        """Discard all interrupted uploads."""
        for name in list(self._partial):
            self._forget(name)
        await asyncio.gather(*self._leaving)

    @asynccontextmanager
    async def receive(
        self, owner: str, chunks: AsyncIterator[bytes], part: Part | None = None
    ) -> AsyncIterator[Received | None]:
        """Receive ``chunks`` and yield the complete upload, or None while parts of it are missing.

        At the end of the block, a complete upload has been stored or is discarded. Raises :class:`UploadOffsetError`;
        :class:`LimitError` as soon as there is more than allowed, and like the chunks; :class:`StorageError` if the
        store fails; and :class:`ReadError` for an empty upload, or one with more bytes than stated.
        """
        self._forget_old()
        upload = self._begin(owner, part)
        upload.busy = True
        finished = False
        try:
            await self._take(upload, chunks)
            finished = part is None or upload.size == part.total
            if finished and upload.size == 0:
                raise ReadError("log.empty", "The upload is empty.")
            yield upload if finished else None
        except LimitError as error:
            finished = finished or error.code not in RESUMED  # other errors would recur
            raise
        except (ReadError, StorageError):
            finished = True
            raise
        finally:
            upload.busy = False
            finished = finished or upload.is_given_up
            if part is not None and finished:
                self._partial.pop((owner, part.key), None)
            if part is None or finished:
                await upload.incoming.discard()

    def _begin(self, owner: str, part: Part | None) -> Received:
        if part is None:
            return Received(self._blobs.incoming())
        name = (owner, part.key)
        known = self._partial.get(name)
        if known is not None and known.busy:
            raise UploadOffsetError("upload.busy", "This upload is already being received over another connection.")
        if known is not None and (part.start == 0 or known.total != part.total):
            self._forget(name)  # the sender starts again
            known = None
        have = 0 if known is None else known.size
        if part.start != have:
            raise UploadOffsetError(
                "upload.offset", f"The server has {have} bytes of this upload; the next part must begin there."
            )
        if known is None:
            self._make_room([key for key in self._partial if key[0] == owner], MAX_PARTIALS_PER_OWNER)
            self._make_room(list(self._partial), MAX_PARTIALS)
            known = self._partial[name] = Received(self._blobs.incoming(), part.total)
        return known

    def _make_room(self, names: list[tuple[str, str]], most: int) -> None:
        """Discard the longest-waiting interrupted upload if there are as many as allowed."""
        if len(names) < most:
            return
        waiting = [name for name in names if not self._partial[name].busy]
        if not waiting:
            raise LimitError("library.busy", "Too many uploads are under way; try again in a moment.")
        self._forget(min(waiting, key=lambda name: self._partial[name].touched_s))

    async def _take(self, upload: Received, chunks: AsyncIterator[bytes]) -> None:
        """Append the chunks; after an interruption, everything received before it too."""
        batch = bytearray()
        try:
            async for chunk in chunks:
                coming = upload.size + len(batch) + len(chunk)
                if coming > self._max_bytes:
                    batch.clear()
                    raise too_large(self._max_bytes)
                if upload.total is not None and coming > upload.total:
                    batch.clear()
                    raise ReadError(
                        "upload.length", f"The upload has more than the {upload.total} bytes that it stated."
                    )
                batch += chunk
                if len(batch) >= BATCH_BYTES:
                    full, batch = batch, bytearray()
                    await upload.write(full)
        finally:
            if batch:
                await upload.write(batch)

    def _forget_old(self) -> None:
        oldest = time.monotonic() - KEEP_PARTIAL_S
        for name, upload in list(self._partial.items()):
            if not upload.busy and upload.touched_s < oldest:
                self._forget(name)

    def _forget(self, name: tuple[str, str]) -> None:
        leaving = asyncio.ensure_future(self._partial.pop(name).incoming.discard())
        self._leaving.add(leaving)
        leaving.add_done_callback(self._leaving.discard)


def too_large(max_bytes: int) -> LimitError:
    """Return the error for an upload over the cap."""
    return LimitError(
        "log.too_large",
        f"An uploaded log may have at most {max_bytes / 1e6:,.0f} MB; this one has more. The service’s setting "
        "GRIDBLOOM_MAX_UPLOAD_BYTES raises this limit; gridbloom on one’s own computer reads logs of any size.",
    )
