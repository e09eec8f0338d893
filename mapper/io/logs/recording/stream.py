"""One stream of messages in a recording: name, size, and refused messages."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

MOST_REASONS = 8  #: of one stream; messages with further reasons are counted together
NO_SUCH_MESSAGE = "their bytes are no message of this type"
_NUMBER = re.compile(r"[-+]?(?:\d[\d.]*(?:e[-+]?\d+)?|\binf\b|\bnan\b)", re.IGNORECASE)


@dataclass(slots=True)
class Reason:
    """Why messages, or parts of them, are refused: ``text`` as stated for the first, and their number."""

    text: str
    first: int  #: index of the first message, from 1
    count: int = 0


@dataclass(slots=True)
class Reasons:
    """Counts of refused messages by reason. Reasons that differ only in their numbers are merged."""

    by_kind: dict[str, Reason] = field(default_factory=dict)

    @property
    def total(self) -> int:
        """Total number refused."""
        return sum(reason.count for reason in self.by_kind.values())

    def add(self, text: str, message: int, count: int = 1) -> None:
        """Count a refusal with the reason ``text`` in the message with this index."""
        kind = _NUMBER.sub("0", text)
        if kind not in self.by_kind and len(self.by_kind) >= MOST_REASONS:
            kind = text = "other reasons"
        self.by_kind.setdefault(kind, Reason(text, message)).count += count

    @property
    def sentence(self) -> str:
        """The reasons, most frequent first, with counts if there are several."""
        reasons = sorted(self.by_kind.values(), key=lambda stream: -stream.count)
        if len(reasons) == 1:
            return _with_first(reasons[0])
        return "; ".join(f"{reason.count} of them: {_with_first(reason)}" for reason in reasons)


@dataclass(slots=True)
class Stream:
    """The messages of one topic, type and serialisation.

    ``refused`` are unused messages, ``left_out`` unused parts of messages otherwise used.
    """

    topic: str
    kind: str
    cdr: bool
    readable: bool = True  #: whether its serialisation is supported
    count: int = 0
    refused: Reasons = field(default_factory=Reasons)
    left_out: Reasons = field(default_factory=Reasons)

    @property
    def bad(self) -> int:
        """Number of unused messages."""
        return self.refused.total

    def refuse(self, why: str = "", message: int | None = None) -> None:
        """Count an unused message, by its index from 1 (None: the last one)."""
        self.refused.add(why or NO_SUCH_MESSAGE, message or self.count)

    def leave_out(self, why: str, parts: int = 1) -> None:
        """Count unused parts of the last message, such as transforms or readings."""
        self.left_out.add(why, self.count, parts)


def _with_first(reason: Reason) -> str:
    return f"{reason.text} (message {reason.first})"
