"""Limits of a library."""

from __future__ import annotations

from dataclasses import dataclass, replace

DAY_S = 86_400.0


@dataclass(frozen=True, slots=True)
class LibraryLimits:
    """Limits on uploads, stored bytes and reading."""

    max_logs_per_owner: int = 50
    max_total_bytes: int = 20 << 30  #: bytes of all uploads together, and of what was read of them
    max_owner_bytes: int = 10 << 30  #: bytes of one visitor's
    max_uploads_at_once: int = 8
    max_uploads_of_owner: int = 4  #: at once, so that a slow sender cannot block others
    keep_s: float = 30 * DAY_S  #: seconds after its last use at which an upload is deleted
    idle_s: float = 30.0  #: seconds with almost no data after which an upload is cancelled
    read_timeout_s: float = 120.0  #: and more for a large file, see :class:`server.library.processing.reader.Reader`
    read_cpu_s: float = 100.0  #: seconds of processor time, likewise
    read_memory_bytes: int = 6 << 30  #: address space of the reading process
    lease_s: float = 15.0  #: for which a service that was killed or cut off keeps its jobs from others
    cache_bytes: int = 512 << 20  #: bytes of logs kept in memory

    def with_room_for(self, upload_bytes: int) -> LibraryLimits:
        """Return limits with room for two uploads of this size of one visitor, and for four of all visitors."""
        return replace(
            self,
            max_owner_bytes=max(self.max_owner_bytes, 2 * upload_bytes),
            max_total_bytes=max(self.max_total_bytes, 4 * upload_bytes),
        )
