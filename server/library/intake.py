"""Taking in uploads: to a temporary file, counted and digested on the way, there whole or not at all.

An upload that names itself (by a key of the sender's choice) may come in parts: what came before a cut is kept for a
while, and the next part goes on from there. One without a key is forgotten when it breaks off.
"""

from __future__ import annotations

import asyncio
import hashlib
import os
import time
import uuid
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mapper.errors import LimitError, MapperError, ReadError

BATCH_BYTES = 1 << 20  #: bytes that go to the disk at a time, in a thread
KEEP_PARTIAL_S = 3600.0  #: seconds after its last byte at which a cut upload is forgotten
MAX_PARTIALS_PER_OWNER = 4
MAX_PARTIALS = 64


class UploadOffsetError(MapperError):
    """The part does not begin where the server's bytes end, or the same upload is coming in already."""


@dataclass(frozen=True, slots=True)
class Part:
    """Which part of an upload comes: ``key`` names the upload, the part begins at byte ``start`` of ``total``."""

    key: str
    start: int
    total: int


@dataclass(slots=True)
class Received:
    """An upload on the disk, not yet in its place: ``size`` bytes of it so far, of ``total`` where that is known."""

    path: Path
    total: int | None = None
    size: int = 0
    digest: Any = field(default_factory=hashlib.sha256)
    busy: bool = False
    touched_s: float = field(default_factory=time.monotonic)
    given_up: bool = False

    @property
    def sha256(self) -> str:
        """Digest of the bytes so far."""
        return str(self.digest.hexdigest())

    def give_up(self) -> None:
        """Remove the file; nothing more is written."""
        self.given_up = True
        self.path.unlink(missing_ok=True)

    def write(self, data: bytes) -> None:
        """Append ``data`` to the file, which is there. Runs in a thread, and may outlive the upload when that ends."""
        try:
            file = self.path.open("r+b", buffering=0)
        except FileNotFoundError:
            if self.given_up:
                return  # what comes late must not make the file again
            raise
        with file:
            file.seek(0, os.SEEK_END)
            view = memoryview(data)
            while view:
                view = view[file.write(view) or 0 :]
        self.digest.update(data)
        self.size += len(data)
        self.touched_s = time.monotonic()


class Intake:
    """The uploads that are under way, or were cut and may go on. Used from the event loop only."""

    def __init__(self, folder: Path, *, max_bytes: int, idle_s: float) -> None:
        self._folder = folder
        self._max_bytes = max_bytes
        self._idle_s = idle_s
        self._partial: dict[tuple[str, str], Received] = {}  #: by owner and key

    @property
    def reserved(self) -> int:
        """Bytes that uploads which may go on take on the disk."""
        return sum(one.size for one in self._partial.values())

    def offset(self, owner: str, key: str) -> int:
        """Return how many bytes of an upload have come; 0 for one that nobody knows, or no longer."""
        self._forget_old()
        known = self._partial.get((owner, key))
        return 0 if known is None else known.size

    def close(self) -> None:
        """Forget every cut upload."""
        for name in list(self._partial):
            self._forget(name)

    @asynccontextmanager
    async def receive(
        self, owner: str, chunks: AsyncIterator[bytes], part: Part | None = None
    ) -> AsyncIterator[Received | None]:
        """Take ``chunks`` in and hand the whole upload over, or None while parts of it are missing.

        On leaving with a whole one, its temporary file is gone or was moved. Raises :class:`UploadOffsetError`;
        :class:`LimitError` as soon as there is more than there may be, when nothing comes for some seconds, and where
        the disk is full; and :class:`ReadError` for an upload without a byte, or one with more bytes than it said.
        """
        self._forget_old()
        upload = self._begin(owner, part)
        upload.busy = True
        finished = False
        try:
            upload.path.touch(0o600)
            await self._take(upload, chunks)
            finished = part is None or upload.size == part.total
            if finished and upload.size == 0:
                raise ReadError("log.empty", "The upload holds no bytes.")
            yield upload if finished else None
        except LimitError as error:
            finished = finished or error.code != "log.stalled"  # nothing else gets better by going on
            raise
        except ReadError:
            finished = True
            raise
        finally:
            upload.busy = False
            if part is not None and finished:
                self._partial.pop((owner, part.key), None)
            if part is None or finished:
                upload.give_up()

    def _begin(self, owner: str, part: Part | None) -> Received:
        path = self._folder / f"{uuid.uuid4().hex}.part"
        if part is None:
            return Received(path)
        name = (owner, part.key)
        known = self._partial.get(name)
        if known is not None and known.busy:
            raise UploadOffsetError("upload.busy", "This upload is coming in already, over another connection.")
        if known is not None and (part.start == 0 or known.total != part.total):
            self._forget(name)  # the sender begins anew
            known = None
        have = 0 if known is None else known.size
        if part.start != have:
            raise UploadOffsetError(
                "upload.offset", f"The server has {have} bytes of this upload; the next part must begin there."
            )
        if known is None:
            self._make_room([one for one in self._partial if one[0] == owner], MAX_PARTIALS_PER_OWNER)
            self._make_room(list(self._partial), MAX_PARTIALS)
            known = self._partial[name] = Received(path, part.total)
        return known

    def _make_room(self, names: list[tuple[str, str]], most: int) -> None:
        """Forget the cut upload that has waited longest where there are as many as there may be."""
        if len(names) < most:
            return
        waiting = [name for name in names if not self._partial[name].busy]
        if not waiting:
            raise LimitError("library.busy", "Too many uploads are under way; try again in a moment.")
        self._forget(min(waiting, key=lambda name: self._partial[name].touched_s))

    async def _take(self, upload: Received, chunks: AsyncIterator[bytes]) -> None:
        """Append the chunks; after a cut, too, all that came is on the disk."""
        batch = bytearray()
        try:
            async for chunk in _with_patience(chunks, self._idle_s):
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
                    full, batch = bytes(batch), bytearray()
                    await _on_disk(upload.write, full)
        finally:
            if batch:
                await _on_disk(upload.write, bytes(batch))

    def _forget_old(self) -> None:
        oldest = time.monotonic() - KEEP_PARTIAL_S
        for name, one in list(self._partial.items()):
            if not one.busy and one.touched_s < oldest:
                self._forget(name)

    def _forget(self, name: tuple[str, str]) -> None:
        self._partial.pop(name).give_up()


def too_large(max_bytes: int) -> LimitError:
    """Return the error for an upload over the cap."""
    return LimitError("log.too_large", f"A log may have at most {max_bytes / 1e6:,.0f} MB; this one has more.")


async def _on_disk(write: Callable[[bytes], None], data: bytes) -> None:
    """Run ``write`` in a thread; a cancelled upload waits for it, so that its file is not closed under it."""
    job = asyncio.ensure_future(asyncio.to_thread(write, data))
    try:
        await asyncio.shield(job)
    except asyncio.CancelledError:
        await asyncio.wait([job])
        raise
    except OSError as error:
        raise LimitError("log.storage", "The server could not store the log; its disk may be full.") from error


async def _with_patience(chunks: AsyncIterator[bytes], idle_s: float) -> AsyncIterator[bytes]:
    """Yield the chunks; raise where none comes for ``idle_s`` seconds."""
    while True:
        try:
            async with asyncio.timeout(idle_s):
                chunk = await anext(chunks)
        except StopAsyncIteration:
            return
        except TimeoutError:
            raise LimitError("log.stalled", f"Nothing of the upload came for {idle_s:g} s.") from None
        yield chunk
