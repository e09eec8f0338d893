"""The fields of one serialised ROS message, read one after the other.

Every length is checked against the bytes that are there before anything is made of it. Source: the ROS wiki's technical
overview (serialisation of ROS 1); OMG DDSI-RTPS, 10 (CDR and its encapsulation header).
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

Pose7 = tuple[float, float, float, float, float, float, float]  #: x y z, and the quaternion x y z w


class BadMessageError(Exception):
    """The bytes are no message of the type that they are said to have; its text says why, where that is known."""


class MessageFields:
    """The fields of one message, in their order."""

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
        """Return numbers of one kind, of ``size`` bytes each; CDR aligns the first to its size."""
        if self.cdr:
            self.pos += -(self.pos - self.origin) % size
        try:
            values = struct.unpack_from(self.order + code, self.data, self.pos)
        except struct.error:
            raise BadMessageError from None
        self.pos += size * len(values)
        return values

    def count(self, least_bytes: int) -> int:
        """Return the length of what follows, of which each element has at least ``least_bytes``."""
        n = int(self.unpack("I", 4)[0])
        if n * least_bytes > len(self.data) - self.pos:
            raise BadMessageError
        return n

    def string(self) -> str:
        """Return a string, without the zero at its end."""
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
            self.unpack("I", 4)  # seq, which ROS 2 dropped
        (seconds,) = self.unpack("i" if self.cdr else "I", 4)
        (nanoseconds,) = self.unpack("I", 4)
        return int(seconds) * 1_000_000_000 + int(nanoseconds), self.frame()

    def frame(self) -> str:
        """Return a frame's name; tf of ROS 1 still wrote a slash before it."""
        return self.string().lstrip("/")

    def bytes(self) -> memoryview:
        """Return a uint8[] as it is, not copied."""
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
