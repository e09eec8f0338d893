"""Uploads being received: the limits of each visitor, the parts, and the record of the received data."""

from __future__ import annotations

import secrets
import time
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass, replace

from mapper.core.errors import LimitError, ReadError
from server.library.loading import LibraryLimits
from server.library.logs.catalogue import Catalogue
from server.library.logs.records import Record, display_name
from server.library.processing.reading_jobs import Jobs, full
from server.library.uploads.receiver import Part, Received, UploadReceiver, too_large
from server.library.uploads.slots import UploadSlots


@dataclass(frozen=True, slots=True)
class Sender:
    """Sender of an upload: a visitor, and a network address; each has a share of the places."""

    owner: str
    address: str = ""


@dataclass(frozen=True, slots=True)
class Declared:
    """Description of an upload by its sender: the log's name, and optionally the total size and the digest.

    ``part`` is the part of the whole that is sent, None: all of it.
    """

    name: str
    size: int | None = None
    sha256: str | None = None
    part: Part | None = None


@dataclass(frozen=True, slots=True)
class Places:
    """Limits of uploads: ``max_bytes`` of one, ``room`` returns the bytes left for all."""

    limits: LibraryLimits
    max_bytes: int
    slots: UploadSlots
    room: Callable[[], int]


class Uploads:
    """Receives uploads into the catalogue, and queues them for reading. Used from the event loop only."""

    def __init__(self, catalogue: Catalogue, receiver: UploadReceiver, jobs: Jobs, places: Places) -> None:
        self._catalogue, self._receiver, self._jobs, self._places = catalogue, receiver, jobs, places

    async def receive(self, sender: Sender, declared: Declared, chunks: AsyncIterator[bytes]) -> Record | None:
        """Store an upload or a part of one; return the record of the complete upload, None while parts are missing.

        If the owner has uploaded the same bytes before, returns the existing record. Raises :class:`LimitError` for an
        upload over a cap, :class:`ReadError` for an empty one and for one with another digest than stated,
        :class:`UploadOffsetError` for a part with another offset, and :class:`StorageError`; the upload is then
        discarded.
        """
        self._check_limits(sender.owner, declared)
        async with (
            self._places.slots.take(sender.owner, sender.address) as slot,
            self._receiver.receive(sender.owner, slot.read(chunks), declared.part) as received,
        ):
            if received is None:
                return None
            if declared.sha256 is not None and received.incoming.sha256 != declared.sha256.lower():
                raise ReadError("upload.digest", "The received bytes differ from those that were sent; try again.")
            return await self._take(sender.owner, display_name(declared.name), received)

    def _check_limits(self, owner: str, declared: Declared) -> None:
        limits, part, size = self._places.limits, declared.part, declared.size or 0
        if size > self._places.max_bytes:
            raise too_large(self._places.max_bytes)
        own = [record for record in self._catalogue.uploaded() if record.owner == owner]
        if len(own) >= limits.max_logs_per_owner:
            raise LimitError(
                "library.too_many",
                f"You have {limits.max_logs_per_owner} logs here, the maximum: delete one.",
            )
        if self._places.room() - self._receiver.reserved < size - (part.start if part else 0):
            raise full()
        if sum(record.bytes + record.packed_bytes for record in own) + size > limits.max_owner_bytes:
            raise LimitError("library.too_many", "Your logs fill the space of one visitor: delete one.")

    async def _take(self, owner: str, name: str, received: Received) -> Record:
        """Store the received bytes and queue them for reading, unless the owner has them already."""
        now = time.time()
        new = Record(
            id=secrets.token_hex(10),
            owner=owner,
            name=name,
            source="upload",
            state="queued",
            bytes=received.size,
            sha256=received.incoming.sha256,
            created_s=now,
            used_s=now,
        )
        record = await self._catalogue.add(new, received.incoming)
        return self._jobs.queue(replace(record, attempts=0)) if record.state in ("queued", "failed") else record
