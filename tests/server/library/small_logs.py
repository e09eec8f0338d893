"""Small logs as bytes, and in pieces as they arrive over the network."""

from __future__ import annotations

from collections.abc import AsyncIterator

LINE = "FLASER 3 1.0 2.0 3.0 {x} 0.0 0.0 {x} 0.0 0.0 {x} host {x}\n"


def carmen(scans: int, start: int = 0) -> bytes:
    """A CARMEN log of ``scans`` scans of three beams, one second and one metre apart."""
    return "".join(LINE.format(x=float(start + i)) for i in range(scans)).encode()


async def in_pieces(data: bytes, size: int = 1000) -> AsyncIterator[bytes]:
    for at in range(0, len(data), size):
        yield data[at : at + size]


def tum(scans: int, y: float = 0.0, start: int = 0) -> bytes:
    """A line for each scan of ``carmen(scans)``: where its robot is, but at ``y``."""
    return "".join(f"{start + i}.0 {start + i}.0 {y} 0 0 0 0 1\n" for i in range(scans)).encode()
