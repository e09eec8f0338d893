"""Pictures and fields of recorded messages, decoded in a process with limits because the data is untrusted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from server.jobs.process import BoundedJob, JobLimits
from server.library.logs.catalogue import Catalogue
from server.library.logs.records import Record
from server.library.processing.recording_worker import RecordingWorker

if TYPE_CHECKING:
    from mapper.io.contents.message_tree import RawMessage

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)

TIMEOUT_S = 60.0  #: of one picture, and of processor time
BYTES_PER_S = 20e6  #: one more second per this number of bytes; a recording without an index is read up to the moment
MEMORY_BYTES = 3 << 30  #: address space of the process


@dataclass(frozen=True, slots=True)
class MomentPicture:
    """A picture of a message that was recorded at ``stamp_ns``."""

    data: bytes
    media_type: str
    stamp_ns: int


@dataclass(frozen=True, slots=True)
class _MomentJob(BoundedJob[T_co]):
    """A job on the newest message of ``topic`` in ``source`` at or before ``at_ns``, by recording time."""

    source: str
    topic: str
    at_ns: int
    limits: JobLimits


@dataclass(frozen=True, slots=True)
class PictureJob(_MomentJob[MomentPicture]):
    """Create a picture of such a message."""

    def compute(self) -> MomentPicture:
        """Return the picture. Raises :class:`ReadError` or :class:`LimitError`."""
        # Only the decoding process needs the readers and the decoders.
        from mapper.io.contents.pictures import picture_of  # noqa: PLC0415
        from mapper.io.contents.seeking import message_at  # noqa: PLC0415

        message = message_at(Path(self.source), self.topic, self.at_ns)
        return MomentPicture(*picture_of(message.type, message.data, cdr=message.cdr), message.stamp_ns)


@dataclass(frozen=True, slots=True)
class MessageJob(_MomentJob["RawMessage"]):
    """Return the fields of such a message."""

    def compute(self) -> RawMessage:
        """Return the message. Raises :class:`ReadError` or :class:`LimitError`."""
        from mapper.io.contents.message_tree import raw_message  # noqa: PLC0415 - as for pictures

        return raw_message(Path(self.source), self.topic, self.at_ns)


class MomentPictures:
    """Computes one picture or message at a time, for waiting addresses and visitors in rotation.

    Used from the event loop only.
    """

    def __init__(self, catalogue: Catalogue) -> None:
        self._worker = RecordingWorker(catalogue, MEMORY_BYTES)

    async def picture(
        self, record: Record, visitor: str, topic: str, at_ns: int, *, address: str = ""
    ) -> MomentPicture:
        """Return a picture of the newest message of ``topic`` at or before ``at_ns``, otherwise of the first one.

        Its process is ended when this is cancelled. Raises the job's errors.
        """
        return await self._done(PictureJob, record, visitor, topic, at_ns, address)

    async def message(self, record: Record, visitor: str, topic: str, at_ns: int, *, address: str = "") -> RawMessage:
        """Return the newest message of ``topic`` at or before ``at_ns``, like :meth:`picture`."""
        return await self._done(MessageJob, record, visitor, topic, at_ns, address)

    async def _done(
        self,
        kind: Callable[[str, str, int, JobLimits], BoundedJob[T]],
        record: Record,
        visitor: str,
        topic: str,
        at_ns: int,
        address: str,
    ) -> T:
        timeout_s = TIMEOUT_S + record.bytes / BYTES_PER_S
        limits = JobLimits(timeout_s, timeout_s, MEMORY_BYTES)
        return await self._worker.done(record, visitor, address, lambda source: kind(source, topic, at_ns, limits))

    async def close(self) -> None:
        """End the process."""
        await self._worker.close()
