"""One stream of messages in a recording: what it is called, and how much there is of it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class Stream:
    """The messages of one topic, type and serialisation."""

    topic: str
    kind: str
    cdr: bool
    count: int = 0
    bad: int = 0
    why: str = ""  #: what is wrong with the first bad one, where it could be decoded

    def refuse(self, why: str = "") -> None:
        """Count a message that could not be read; ``why`` is kept of the first."""
        self.bad += 1
        if why and not self.why:
            self.why = why
