"""Sequential reading of the fields of a serialised ROS message.

Every length is checked against the available bytes before it is used. Source: the ROS wiki's technical overview
(serialisation of ROS 1); OMG DDSI-RTPS, 10 (CDR and its encapsulation header).
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

Pose7 = tuple[float, float, float, float, float, float, float]  #: x y z, and the quaternion x y z w


class BadMessageError(Exception):
    """The bytes are not a message of the stated type; the text is the reason, if known."""


class MessageFields:
    """The fields of one message, in order."""

    def __init__(self, data: bytes, *, cdr: bool) -> None:
        self.data = data
        self.cdr = cdr
        self.pos = self.origin = 0
        self.order = "<"
        if cdr:
            if len(data) < 4 or data[0] != 0 or data[1] > 1:
                raise BadMessageError
            self.order = "<" if data[1] else ">"
            self.pos = self.origin = 4

    def unpack(self, code: str, size: int) -> tuple[float, ...]:
        """Return numbers of one type, of ``size`` bytes each; CDR aligns the first to its size."""
        if self.cdr:
            self.pos += -(self.pos - self.origin) % size
        try:
            values = struct.unpack_from(self.order + code, self.data, self.pos)
        except struct.error:
            raise BadMessageError from None
        self.pos += size * len(values)
        return values

    def count(self, least_bytes: int) -> int:
        """Return the length of the following sequence, whose elements have at least ``least_bytes`` each."""
        n = int(self.unpack("I", 4)[0])
        if n * least_bytes > len(self.data) - self.pos:
            raise BadMessageError
        return n

    def string(self) -> str:
        """Return a string without its terminating zero."""
        n = self.count(1)
        text = self.data[self.pos : self.pos + n]
        self.pos += n
        return text.rstrip(b"\0").decode("utf-8", "replace")

    def floats(self) -> NDArray[np.float32]:
        """Return a float32[] (n,)."""
        n = self.count(4)
        values = np.frombuffer(self.data, self.order + "f4", n, self.pos)
        self.pos += 4 * n
        return values

    def header(self) -> tuple[int, str]:
        """Return a std_msgs/Header's stamp in nanoseconds, and its frame."""
        if not self.cdr:
            self.unpack("I", 4)  # seq, which ROS 2 removed
        (seconds,) = self.unpack("i" if self.cdr else "I", 4)
        (nanoseconds,) = self.unpack("I", 4)
        return int(seconds) * 1_000_000_000 + int(nanoseconds), self.frame()

    def frame(self) -> str:
        """Return a frame name; tf of ROS 1 still wrote a leading slash."""
        return self.string().lstrip("/")

    def bytes(self) -> memoryview:
        """Return a uint8[] without copying."""
        n = self.count(1)
        values = memoryview(self.data)[self.pos : self.pos + n]
        self.pos += n
        return values

    def pose(self) -> Pose7:
        """Return a geometry_msgs/Pose, or a Transform, which has the same fields."""
        x, y, z, qx, qy, qz, qw = self.unpack("7d", 8)
        return (x, y, z, qx, qy, qz, qw)

    def end(self, at_most: int = 0) -> None:
        """Check that nothing follows; CDR may pad to four bytes."""
        if len(self.data) - self.pos > (3 if self.cdr else 0) + at_most:
            raise BadMessageError
