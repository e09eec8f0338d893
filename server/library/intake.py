"""Taking in an upload: to a temporary file, counted and digested on the way, there whole or not at all."""

from __future__ import annotations

import asyncio
import hashlib
import os
import uuid
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

from mapper.errors import LimitError, ReadError

BATCH_BYTES = 1 << 20  #: bytes that go to the disk at a time, in a thread


@dataclass(frozen=True, slots=True)
class Received:
    """An upload on the disk, not yet in its place."""

    path: Path
    bytes: int
    sha256: str


@asynccontextmanager
async def receive(
    chunks: AsyncIterator[bytes], folder: Path, *, max_bytes: int, idle_s: float
) -> AsyncIterator[Received]:
    """Write ``chunks`` to a new file of ``folder`` and hand it over; on leaving, the file is gone or was moved.

    Raises :class:`LimitError` as soon as there are more than ``max_bytes`` or when nothing comes for ``idle_s``
    seconds, and :class:`ReadError` for an upload without a byte.
    """
    path = folder / f"{uuid.uuid4().hex}.part"
    digest = hashlib.sha256()
    size = 0
    batch = bytearray()
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    try:
        with os.fdopen(handle, "wb", buffering=0) as file:

            def write(data: bytes) -> None:
                digest.update(data)
                view = memoryview(data)
                while view:
                    view = view[file.write(view) or 0 :]

            async for chunk in _with_patience(chunks, idle_s):
                size += len(chunk)
                if size > max_bytes:
                    raise too_large(max_bytes)
                batch += chunk
                if len(batch) >= BATCH_BYTES:
                    await _on_disk(write, bytes(batch))
                    batch.clear()
            await _on_disk(write, bytes(batch))
        if size == 0:
            raise ReadError("log.empty", "The upload holds no bytes.")
        yield Received(path, size, digest.hexdigest())
    finally:
        path.unlink(missing_ok=True)


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
