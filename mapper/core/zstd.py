"""Zstandard compression for what is kept in memory."""

from __future__ import annotations

import zstandard


def compressed(compressor: zstandard.ZstdCompressor, data: bytes | memoryview) -> bytes:
    """Return ``data`` compressed, in no more memory than that needs.

    What ``ZstdCompressor.compress`` returns occupies as much as the largest possible result would: python-zstandard
    shortens it without giving the rest back.
    """
    return bytes(memoryview(compressor.compress(data)))
