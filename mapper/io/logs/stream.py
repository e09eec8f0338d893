"""One stream of messages in a recording: what it is called, and how much there is of it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class Stream:
    """The messages of one topic, type and serialisation; the stamps are those of the recorder."""

    topic: str
    kind: str
    cdr: bool
    count: int = 0
    bad: int = 0
    why: str = ""  #: what is wrong with the first bad one, where it could be decoded
    bytes: int = 0
    first_stamp_ns: int | None = None
    last_stamp_ns: int | None = None

    def note(self, stamp_ns: int, size: int) -> None:
        """Count one message of ``size`` bytes, recorded at ``stamp_ns``, 0 where that is not known."""
        self.count += 1
        self.bytes += size
        if stamp_ns:
            if self.first_stamp_ns is None or stamp_ns < self.first_stamp_ns:
                self.first_stamp_ns = stamp_ns
            if self.last_stamp_ns is None or stamp_ns > self.last_stamp_ns:
                self.last_stamp_ns = stamp_ns

    def refuse(self, why: str = "") -> None:
        """Count a message that could not be read; ``why`` is kept of the first."""
        self.bad += 1
        if why and not self.why:
            self.why = why
