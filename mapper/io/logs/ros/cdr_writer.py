"""Serialisation of ROS 2 messages (CDR, little-endian). Source: OMG DDSI-RTPS, 10."""

from __future__ import annotations

import struct
from typing import Self

import numpy as np
from numpy.typing import NDArray

SECOND = 1_000_000_000
ENCAPSULATION = b"\0\1\0\0"  #: plain CDR, little-endian


class CdrWriter:
    """A message under construction; each number is aligned to its size, relative to the end of the encapsulation."""

    def __init__(self) -> None:
        self.data = bytearray(ENCAPSULATION)

    def pack(self, code: str, size: int, *values: float) -> Self:
        """Append numbers of one type, of ``size`` bytes each."""
        self.data += bytes((len(ENCAPSULATION) - len(self.data)) % size) + struct.pack(f"<{len(values)}{code}", *values)
        return self

    def string(self, text: str) -> Self:
        """Append a string."""
        raw = text.encode() + b"\0"
        self.pack("I", 4, len(raw)).data += raw
        return self

    def header(self, stamp_ns: int, frame: str) -> Self:
        """Append a std_msgs/Header."""
        seconds, nanoseconds = divmod(stamp_ns, SECOND)
        return self.pack("i", 4, seconds).pack("I", 4, nanoseconds).string(frame)

    def array(self, values: NDArray[np.float32] | NDArray[np.int8] | NDArray[np.uint8]) -> Self:
        """Append numbers (n,) of at most four bytes, preceded by their count."""
        self.pack("I", 4, len(values)).data += np.ascontiguousarray(values).view(np.uint8).data
        return self

    @property
    def message(self) -> bytes:
        """Return the message."""
        return bytes(self.data)
