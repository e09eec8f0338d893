"""Selection and order of the logs in a list."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from server.library.logs.records import Record

Order = Literal["newest", "name", "duration", "scans", "size"]


@dataclass(frozen=True, slots=True)
class LogQuery:
    """A log matches if all ``words`` occur in its name, format, topics or tags, and it has all ``tags``.

    Of the matching logs in this ``order``, ``limit`` from ``offset`` on are selected; None for all.
    """

    words: str = ""
    tags: tuple[str, ...] = ()
    order: Order = "newest"
    offset: int = 0
    limit: int | None = None


@dataclass(frozen=True, slots=True)
class Listing:
    """One page of the matching logs; ``total`` is their number, ``tags`` the number of logs with each tag."""

    records: Sequence[Record]
    total: int
    tags: Mapping[str, int]


_KEYS: dict[Order, Callable[[Record], Any]] = {
    "name": lambda record: record.name.casefold(),
    "duration": lambda record: -(record.summary.duration_s if record.summary else -math.inf),
    "scans": lambda record: -(record.summary.scans if record.summary else -1),
    "size": lambda record: -record.bytes,
}


def listed(records: Sequence[Record], selection: LogQuery) -> Listing:
    """Return the page of ``records``, which are in the order "newest". Tags are counted over all records."""
    words = selection.words.casefold().split()
    matching = [record for record in records if set(selection.tags) <= set(record.tags) and _has(record, words)]
    key = _KEYS.get(selection.order)
    if key is not None:
        matching.sort(key=key)
    end = None if selection.limit is None else selection.offset + selection.limit
    tags = Counter(tag for record in records for tag in record.tags)
    return Listing(matching[selection.offset : end], len(matching), dict(sorted(tags.items())))


def _has(record: Record, words: Sequence[str]) -> bool:
    if not words:
        return True
    summary = record.summary
    texts = [record.name, *record.tags]
    if summary is not None:
        texts += [summary.format, *(topic.name for topic in summary.topics)]
    whole = "\n".join(texts).casefold()
    return all(word in whole for word in words)
