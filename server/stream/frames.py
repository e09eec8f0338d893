"""WebSocket messages from a server: unmasked, unfragmented, and the same bytes for every client (RFC 6455, 5.2)."""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import Protocol

#: The extension of the ASGI scope of a connection that accepts complete frames as the item ``frames`` of a
#: ``websocket.send`` message. They are written immediately, in one system call. Its item ``socket`` is a
#: :class:`DirectSocket`.
EXTENSION = "gridbloom.frames"


class DirectSocket(Protocol):
    """A WebSocket that is used without a task of its own, because hundreds of clients wait for each tick.

    ``on_text`` is called with each text message and returns whether it handled it; others are passed to ASGI.
    """

    on_text: Callable[[bytes], bool] | None

    def is_ready(self) -> bool:
        """Return whether the client is connected, and has read enough of the earlier data."""
        ...

    def write(self, frames: bytes) -> None:
        """Write complete frames."""
        ...


_FINAL_TEXT, _FINAL_BINARY = 0x81, 0x82


def _head(first: int, length: int) -> bytes:
    if length < 126:
        return bytes((first, length))
    if length < 1 << 16:
        return struct.pack(">BBH", first, 126, length)
    return struct.pack(">BBQ", first, 127, length)


def text_frame(text: str) -> bytes:
    """Return the frame of a text message."""
    data = text.encode()
    return _head(_FINAL_TEXT, len(data)) + data


def binary_frame(parts: Sequence[bytes]) -> bytes:
    """Return the frame of a binary message that consists of ``parts``."""
    return b"".join((_head(_FINAL_BINARY, sum(map(len, parts))), *parts))
