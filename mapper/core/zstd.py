"""Zstandard compression of data kept in memory."""

from __future__ import annotations

import zstandard


def compressed(compressor: zstandard.ZstdCompressor, data: bytes | memoryview) -> bytes:
    """Return ``data`` compressed, in a buffer of exactly the compressed size.

    The result of ``ZstdCompressor.compress`` occupies the memory of the largest possible output, because
    python-zstandard shortens it without releasing the rest.
    """
    return bytes(memoryview(compressor.compress(data)))
