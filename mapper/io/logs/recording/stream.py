"""One stream of messages in a recording: what it is called, how much there is of it, and what of it is refused."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

MOST_REASONS = 8  #: of one stream: messages of further reasons are counted together
NO_SUCH_MESSAGE = "their bytes are no message of this type"
_NUMBER = re.compile(r"[-+]?(?:\d[\d.]*(?:e[-+]?\d+)?|\binf\b|\bnan\b)", re.IGNORECASE)


@dataclass(slots=True)
class Reason:
    """Why messages, or parts of them, are not taken: ``text`` as it was stated of the first, and how many they are."""

    text: str
    first: int  #: number of the first message, from 1
    count: int = 0


@dataclass(slots=True)
class Reasons:
    """Counts of what is refused, by reason. Reasons that differ in their numbers alone are one."""

    by_kind: dict[str, Reason] = field(default_factory=dict)

    @property
    def total(self) -> int:
        """How many are refused in all."""
        return sum(reason.count for reason in self.by_kind.values())

    def add(self, text: str, message: int, count: int = 1) -> None:
        """Count what is refused because of ``text`` in the message of this number."""
        kind = _NUMBER.sub("0", text)
        if kind not in self.by_kind and len(self.by_kind) >= MOST_REASONS:
            kind = text = "other reasons"
        self.by_kind.setdefault(kind, Reason(text, message)).count += count

    @property
    def sentence(self) -> str:
        """The reasons, most frequent first, each with its count where there are several."""
        reasons = sorted(self.by_kind.values(), key=lambda stream: -stream.count)
        if len(reasons) == 1:
            return _with_first(reasons[0])
        return "; ".join(f"{reason.count} of them: {_with_first(reason)}" for reason in reasons)


@dataclass(slots=True)
class Stream:
    """The messages of one topic, type and serialisation.

    ``refused`` are messages of which nothing is taken, ``left_out`` parts of messages of which the rest is taken.
    """

    topic: str
    kind: str
    cdr: bool
    readable: bool = True  #: whether its serialisation is one that is read
    count: int = 0
    refused: Reasons = field(default_factory=Reasons)
    left_out: Reasons = field(default_factory=Reasons)

    @property
    def bad(self) -> int:
        """Messages of which nothing is taken."""
        return self.refused.total

    def refuse(self, why: str = "", message: int | None = None) -> None:
        """Count a message, by its number from 1 (None: the one that was taken last), of which nothing is taken."""
        self.refused.add(why or NO_SUCH_MESSAGE, message or self.count)

    def leave_out(self, why: str, parts: int = 1) -> None:
        """Count parts of the message that was taken last, as transforms or readings, that are not taken."""
        self.left_out.add(why, self.count, parts)


def _with_first(reason: Reason) -> str:
    return f"{reason.text} (message {reason.first})"
