"""Files of named arrays, the format of all packs. Everything else is JSON, in the array ``about``."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.atomic_file import atomic_write
from mapper.core.errors import MapperError

Arrays = Mapping[str, NDArray[Any]]

#: Errors of reading such a file if it is damaged, of another kind, or missing.
UNREADABLE = (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, MapperError)


def about_array(text: str) -> NDArray[np.uint8]:
    """Return the UTF-8 bytes of a text as an array (n,)."""
    return np.frombuffer(text.encode(), dtype=np.uint8)


def write_arrays(path: Path, about: str, arrays: Arrays) -> None:
    """Write a pack atomically: it is complete, or as it was before. Raises :class:`OSError`."""
    stored: dict[str, Any] = {"about": about_array(about), **arrays}
    with atomic_write(path) as file:
        np.savez(file, **stored)


def halves_of(path: Path) -> Iterable[Path]:
    """Return temporary files left by a process that was killed while writing ``path``."""
    return path.parent.glob(f".{path.name}.*")


def compressed_arrays(arrays: Arrays) -> bytes:
    """Return the bytes of a file of arrays, compressed."""
    out = io.BytesIO()
    stored: dict[str, Any] = {**arrays}
    np.savez_compressed(out, **stored)
    return out.getvalue()
