"""Streaming decompression with a limit on the output: sizes in frame headers are not trusted.

zstandard's own limit is ignored if a frame declares a size, and the one-call functions of bz2 and lz4 have none, so
each is called piece by piece here.
"""

from __future__ import annotations

import bz2
import io

import lz4.frame
import zstandard

from mapper.core.errors import LimitError, ReadError

ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
PIECE = 1 << 20
MAX_WINDOW = 1 << 27  #: bytes: the window of `zstd --long`; a frame may request terabytes


_DECOMPRESSORS = {"bz2": bz2.BZ2Decompressor, "lz4": lz4.frame.LZ4FrameDecompressor}
KINDS = frozenset({"zstd", *_DECOMPRESSORS})


def inflate(kind: str, data: bytes, most: int, what: str) -> tuple[bytes, bool]:
    """Decompress ``data``, and return whether its end was reached; cut data yields the part before the cut.

    ``kind`` is one of :data:`KINDS`; ``what`` names the data in errors. Raises :class:`LimitError` as soon as there are
    more than ``most`` bytes, and :class:`ReadError` for damaged data.
    """
    try:
        if kind == "zstd":
            return _inflate_zstd(data, most, what)
        stream = _DECOMPRESSORS[kind]()
        out = io.BytesIO()
        while not stream.eof:
            piece = stream.decompress(data, min(PIECE, most + 1 - out.tell()))
            data = b""
            if not piece:
                break
            out.write(piece)
            if out.tell() > most:
                raise _too_large(what, most)
    except (OSError, EOFError, RuntimeError, ValueError, zstandard.ZstdError) as error:
        raise ReadError("log.compression", f"The {kind} data of {what} is damaged.") from error
    return out.getvalue(), stream.eof


def _inflate_zstd(data: bytes, most: int, what: str) -> tuple[bytes, bool]:
    out = io.BytesIO()
    stream = zstandard.ZstdDecompressor(max_window_size=MAX_WINDOW).stream_reader(data, read_across_frames=True)
    while piece := stream.read(min(PIECE, most + 1 - out.tell())):
        out.write(piece)
        if out.tell() > most:
            raise _too_large(what, most)
    whole = zstandard.frame_content_size(data)
    return out.getvalue(), whole < 0 or out.tell() >= whole


def _too_large(what: str, most: int) -> LimitError:
    return LimitError("log.too_many_bytes", f"{what[:1].upper()}{what[1:]} expands to more than {most} bytes.")
