"""viser's buffer of outgoing messages, with a limit on how many bytes are sent at once.

viser sends up to 128 messages of any size in one WebSocket message; a browser that connects gets the whole scene.
"""

from __future__ import annotations

from collections.abc import AsyncGenerator, Iterator, Sequence
from dataclasses import is_dataclass
from typing import Any

import numpy as np
from viser.infra import Message
from viser.infra._async_message_buffer import AsyncMessageBuffer

MAX_TOGETHER = 4 << 20  #: bytes of messages that are sent at once; a larger message is sent alone


def size_of(value: Any) -> int:  # noqa: ANN401 - any field of a message
    """Return the bytes of the arrays and byte strings in a message or one of its fields."""
    if isinstance(value, np.ndarray):
        return value.nbytes
    if isinstance(value, bytes):
        return len(value)
    if isinstance(value, dict):
        return sum(size_of(one) for one in value.values())
    if isinstance(value, Message) or is_dataclass(value):
        return sum(size_of(held) for held in vars(value).values())
    return 0


def parts_of(window: Sequence[Message]) -> Iterator[Sequence[Message]]:
    """Yield the messages in order, in parts of at most :data:`MAX_TOGETHER` bytes or of one message."""
    part: list[Message] = []
    size = 0
    for message in window:
        more = size_of(message)
        if part and size + more > MAX_TOGETHER:
            yield part
            part, size = [], 0
        part.append(message)
        size += more
    if part:
        yield part


class MessageBuffer(AsyncMessageBuffer):
    """viser's buffer, with its windows divided by :func:`parts_of`."""

    async def _window_loop(
        self, client_id: int, backlog_last_id: int, backlog_done_message: Message | None
    ) -> AsyncGenerator[Sequence[Message], None]:
        windows = super()._window_loop(client_id, backlog_last_id, backlog_done_message)
        try:
            async for window in windows:
                for part in parts_of(window):
                    yield part
        finally:
            await windows.aclose()
