"""A compressed copy of an image."""

from __future__ import annotations

import tempfile
import threading
import weakref
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import zstandard
from numpy.typing import NDArray

from mapper.core.zstd import compressed
from mapper.io.maps.images import Bands

MEMORY_BYTES = 8 << 20  #: of compressed pixels that stay in memory; further ones are written to a file
ZSTD_LEVEL = 1


class CompressedImage:
    """An image of ``shape`` (rows, cols), in bands of whole rows, from top to bottom.

    Most of a large map is unobserved, so megabytes of pixels usually compress to a few hundred kilobytes.
    """

    def __init__(self, shape: tuple[int, int], bands: Bands, folder: Path, check: Callable[[], None]) -> None:
        """Compress ``bands`` (worker thread). ``check`` is called for each and may raise to stop."""
        self.shape = shape
        self._places: list[tuple[int, int, tuple[int, ...]]] = []  #: start of each band, its bytes, its shape
        self._reading = threading.Lock()
        file = tempfile.SpooledTemporaryFile(max_size=MEMORY_BYTES, dir=str(folder))  # noqa: SIM115 - ends with the object
        self._file = file
        weakref.finalize(self, file.close)
        compressor = zstandard.ZstdCompressor(level=ZSTD_LEVEL)
        at = 0
        for band in bands:
            check()
            packed = compressed(compressor, np.ascontiguousarray(band).data)
            file.write(packed)
            self._places.append((at, len(packed), band.shape))
            at += len(packed)
        self.nbytes = at

    def bands(self) -> Iterator[NDArray[np.uint8]]:
        """Yield the original bands."""
        decompressor = zstandard.ZstdDecompressor()
        for at, size, shape in self._places:
            with self._reading:
                self._file.seek(at)
                packed = self._file.read(size)
            yield np.frombuffer(decompressor.decompress(packed), dtype=np.uint8).reshape(shape)
