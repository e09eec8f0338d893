"""Data that expands to gibibytes, made in milliseconds by repeating one compressed piece.

Source: RFC 1951 (deflate: a stream may be flushed to a byte's border and go on); RFC 8878 (Zstandard's blocks of one
byte, repeated); the LZ4 frame format (independent blocks); bzip2 (blocks of bits, and how their checksums combine).
"""

from __future__ import annotations

import bz2
import struct
import zlib

import lz4.frame

GIB = 1 << 30


def of_zeros(kind: str, size: int, before: bytes = b"") -> bytes:
    """Return ``before`` and then about ``size`` zeros, packed as "gzip", "zstd", "zstd, no size", "bz2" or "lz4"."""
    if kind.startswith("zstd"):
        return _zstd(size, before, stated=kind == "zstd")
    assert not before or kind == "gzip"
    return {"gzip": lambda: _gzip(size, before), "bz2": lambda: _bz2(size), "lz4": lambda: _lz4(size)}[kind]()


def _gzip(size: int, before: bytes) -> bytes:
    packer = zlib.compressobj(9, wbits=31)
    head = packer.compress(before) + packer.flush(zlib.Z_FULL_FLUSH)
    one = packer.compress(bytes(1 << 20)) + packer.flush(zlib.Z_FULL_FLUSH)
    return head + one * (size >> 20) + packer.flush()


def _zstd(size: int, before: bytes, *, stated: bool) -> bytes:
    block = 1 << 17
    n = size // block
    # A window of 128 KiB; the content's size in 8 bytes, or not at all.
    head = b"\x28\xb5\x2f\xfd" + (
        bytes([0xC0, 7 << 3]) + struct.pack("<Q", len(before) + n * block) if stated else bytes([0x00, 7 << 3])
    )
    raw = struct.pack("<I", len(before) << 3)[:3] + before if before else b""
    repeated = struct.pack("<I", block << 3 | 1 << 1)[:3] + b"\0"
    last = struct.pack("<I", 1)[:3]
    return head + raw + repeated * n + last


def _bz2(size: int) -> bytes:
    """Return a stream of one block many times over: the bits between its header and its end, and a new checksum."""
    piece = bytes(40_000_000)  # less than a block of the ninth level holds
    one = bz2.compress(piece, 9)
    bits = int.from_bytes(one, "big")
    total = len(one) * 8
    end = next(spare for spare in range(8) if bits >> (spare + 32) & ((1 << 48) - 1) == 0x177245385090)
    body_bits = total - 32 - 80 - end
    body = bits >> (80 + end) & ((1 << body_bits) - 1)
    checksum = body >> (body_bits - 80) & 0xFFFFFFFF  # after the block's own 48 bits
    n = -(-size // len(piece))
    combined, text = 0, []
    for _ in range(n):
        combined = ((combined << 1 | combined >> 31) & 0xFFFFFFFF) ^ checksum
        text.append(f"{body:0{body_bits}b}")
    text.append(f"{0x177245385090:048b}{combined:032b}")
    joined = "".join(text)
    joined += "0" * (-len(joined) % 8)
    return one[:4] + int(joined, 2).to_bytes(len(joined) // 8, "big")


def _lz4(size: int) -> bytes:
    """Return a frame of independent blocks of 4 MiB."""
    block = 4 << 20
    one: bytes = lz4.frame.compress(
        bytes(block),
        block_size=lz4.frame.BLOCKSIZE_MAX4MB,
        block_linked=False,
        store_size=False,
        content_checksum=False,
    )
    (length,) = struct.unpack_from("<I", one, 7)
    return one[:7] + one[7 : 11 + length] * (size // block) + bytes(4)
