"""One message of a recording as a tree: the newest of a topic at a moment."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mapper.core.errors import ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.contents.message_tree import Tree, tree_of
from mapper.io.contents.seeking import Stated, message_at, stated_in

TEXT_DEFINITIONS = ("ros1msg", "ros2msg")


@dataclass(frozen=True, slots=True)
class RawMessage:
    """A message: its type, when it was recorded, its size, and its fields."""

    type: str
    stamp_ns: int
    bytes: int
    tree: Tree


def raw_message(path: Path, topic: str, at_ns: int, limits: Limits = DEFAULT_LIMITS) -> RawMessage:
    """Return the newest message of ``topic`` that was recorded at or before ``at_ns``; before the first, the first.

    Raises :class:`ReadError` where there is none, or where it cannot be read with what the recording says of its type,
    and :class:`LimitError`.
    """
    found = message_at(path, topic, at_ns, limits)
    tree = tree_of(found.type, definition_of(path, topic, limits), found.data, cdr=found.cdr)
    return RawMessage(found.type, found.stamp_ns, len(found.data), tree)


def definition_of(path: Path, topic: str, limits: Limits = DEFAULT_LIMITS) -> str:
    """Return the definition that a recording carries of the messages of a topic, as text.

    Raises :class:`ReadError` where it has none, or one of another kind than ROS's own.
    """
    return text_of(topic, stated_in(path, (topic,), limits).get(topic))


def text_of(topic: str, stated: Stated | None) -> str:
    """Return the text of what a recording states of a topic. Raises :class:`ReadError` as :func:`definition_of`."""
    if stated is None or not stated.definition.strip():
        raise ReadError(
            "message.no_definition",
            f"The recording does not define the type of {topic!r:.200}: bags before ROS 2 Iron and files without an "
            "index do not.",
        )
    if stated.definition_encoding not in TEXT_DEFINITIONS:
        raise ReadError(
            "message.encoding",
            f"Message definitions of the kind {stated.definition_encoding!r:.40} are not read, only ROS .msg.",
        )
    return stated.definition
