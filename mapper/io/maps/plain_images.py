"""PGM, PBM and PPM files, made safe for Pillow's reader: a header of limited length, and plain files without comments.

Source: netpbm's pgm(5).
"""

from __future__ import annotations

import io
import re
from typing import BinaryIO

from PIL import PpmImagePlugin

from mapper.core.errors import LimitError

MOST_HEADER_BYTES = 1 << 17  #: with its comments: Pillow reads a header byte by byte
PLAIN = (b"P1", b"P2", b"P3")
_BLOCK = 1 << 20
_COMMENT = re.compile(rb"#[^\r\n]*[\r\n]?")


def open_plain_image(file: BinaryIO, named: str) -> PpmImagePlugin.PpmImageFile:
    """Return the image in ``file``; ``named`` begins the sentence of an error.

    Raises :class:`LimitError` for a header longer than :data:`MOST_HEADER_BYTES`, and what Pillow raises.
    """
    head = file.read(MOST_HEADER_BYTES)
    file.seek(0)
    header = io.BytesIO(head)
    try:
        PpmImagePlugin.PpmImageFile(header)
    except ValueError:
        if header.tell() < MOST_HEADER_BYTES:
            raise
        raise LimitError(
            "map.image_header", f"{named} has a header of more than {MOST_HEADER_BYTES} bytes, comments included."
        ) from None
    is_plain = head.startswith(PLAIN)
    return PpmImagePlugin.PpmImageFile(_WithoutComments(file) if is_plain else file)  # type: ignore[arg-type]


class _WithoutComments:
    """A file read without its comments, from # to the end of the line, in time linear in its length.

    Pillow copies the rest of a block of 1 MB for every comment in it.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._window = io.BytesIO()
        self._in_comment = False
        self._at = 0

    def read(self, size: int) -> bytes:
        """Return at most ``size`` bytes, and none only at the end."""
        while not (data := self._window.read(size)):
            block = self._file.read(_BLOCK)
            if not block:
                return b""
            self._window = io.BytesIO(self._stripped(block))
        self._at += len(data)
        return data

    def tell(self) -> int:
        """Return how many bytes were read."""
        return self._at

    def seek(self, offset: int) -> None:
        """Go to ``offset``, counted without the comments."""
        self._file.seek(0)
        self._window = io.BytesIO()
        self._in_comment = False
        self._at = 0
        while self._at < offset and self.read(min(_BLOCK, offset - self._at)):
            pass

    def _stripped(self, block: bytes) -> bytes:
        if self._in_comment:
            block = b"#" + block
        last = block.rfind(b"#")
        self._in_comment = last >= 0 and not re.search(rb"[\r\n]", block[last:])
        return _COMMENT.sub(b"", block)
