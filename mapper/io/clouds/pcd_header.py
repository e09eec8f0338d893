"""Parser of PCD headers, in the variants in use.

Source: "The PCD (Point Cloud Data) file format" of PCL's documentation; ``pcl::PCDReader::readHeader`` for optional
lines. pypcd4 is not used because it rejects lower-case types, counts of zero and other header lines that PCL, Open3D or
PDAL accept.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np

from mapper.core.errors import ReadError
from mapper.io.logs.names import printable

MOST_HEADER_BYTES = 1 << 16
MOST_NUMBERS = 4096  #: per point
WORDS = ("VERSION", "FIELDS", "COLUMNS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA")
KINDS = ("ascii", "binary", "binary_compressed")
_FIELDS = re.compile(rb"^[ \t]*(fields|columns)[ \t]", re.MULTILINE | re.IGNORECASE)
_SIZES = {"F": (4, 8), "I": (1, 2, 4, 8), "U": (1, 2, 4, 8)}


@dataclass(frozen=True, slots=True)
class Field:
    """A field of each point: ``count`` numbers of a NumPy type. Padding has a name that starts with ``_``."""

    name: str
    kind: str
    count: int

    @property
    def is_padding(self) -> bool:
        """Whether its bytes are unused."""
        return self.name.startswith("_")


@dataclass(frozen=True, slots=True)
class PcdHeader:
    """Contents of a header; the data starts at byte ``begin``.

    ``shape`` is (height, width), None if that does not match the number of points, with a sentence in ``notes``.
    ``viewpoint`` is x y z, and a quaternion w x y z.
    """

    fields: tuple[Field, ...]
    points: int
    shape: tuple[int, int] | None
    viewpoint: tuple[float, ...]
    kind: str
    begin: int
    notes: tuple[str, ...] = ()

    def dtype(self) -> np.dtype[np.void]:
        """Return the type of a point in binary data: fields ``f0``, ``f1`` … for those of the file."""
        parts = [(f"f{k}", f"<{field.kind}", (field.count,)) for k, field in enumerate(self.fields)]
        return np.dtype(parts)

    def written(self, n: int) -> bytes:
        """Return a header of version 0.7 for the first ``n`` points, with fields named ``f0``, ``f1`` …"""
        kinds = {"f": "F", "i": "I", "u": "U"}
        rows = {
            "FIELDS": [f"f{k}" for k in range(len(self.fields))],
            "SIZE": [field.kind[1] for field in self.fields],
            "TYPE": [kinds[field.kind[0]] for field in self.fields],
            "COUNT": [str(field.count) for field in self.fields],
            "WIDTH": [str(n)],
            "HEIGHT": ["1"],
            "POINTS": [str(n)],
            "DATA": [self.kind],
        }
        return "".join(f"{name} {' '.join(words)}\n" for name, words in {"VERSION": ["0.7"], **rows}.items()).encode()


def looks_like_pcd(head: bytes) -> bool:
    """Return whether a file that starts with ``head`` is PCD: its first word after comments, and a FIELDS line."""
    for line in head.split(b"\n"):
        words = line.split()
        if words and not words[0].startswith(b"#"):
            return words[0].decode("latin-1").upper() in WORDS and _FIELDS.search(head) is not None
        if line.startswith(b"# .PCD"):
            return True
    return False


def pcd_header(data: bytes) -> PcdHeader:
    """Return the header at the beginning of a file. Raises :class:`ReadError`, naming the invalid line."""
    lines, begin = _lines(data)
    names = lines.get("FIELDS") or lines.get("COLUMNS") or []
    if not names:
        raise ReadError("cloud.header", "The PCD header’s FIELDS is missing or wrong: it names no fields.")
    sizes = lines.get("SIZE") or ["4"] * len(names)
    types = [word.upper() for word in lines.get("TYPE") or ["F"] * len(names)]
    counts = lines.get("COUNT") or ["1"] * len(names)  # "if not given, 1 for all"
    if len({len(names), len(sizes), len(types), len(counts)}) != 1:
        raise ReadError("cloud.header", "The header’s FIELDS, SIZE, TYPE and COUNT have different lengths.")
    wrong = next((word for word in types if word not in _SIZES), None)
    if wrong is not None:
        text = printable(wrong[:20])
        raise ReadError("cloud.header", f"The PCD header’s TYPE is missing or wrong: {text!r} is not F, I or U.")
    fields = []
    for name, size, kind, count in zip(names, sizes, types, counts, strict=True):
        if not size.isdigit() or int(size[:4]) not in _SIZES[kind]:
            text = printable(f"{kind} {size}"[:20])
            raise ReadError("cloud.header", f"The header’s TYPE and SIZE {text!r} are not types of a PCD file.")
        n = _whole(count, "COUNT")
        if n:  # a field without numbers has no bytes
            fields.append(Field(printable(name[:100]), f"{kind.lower()}{size}", n))
    if sum(field.count for field in fields) > MOST_NUMBERS:
        raise ReadError("cloud.header", f"A point has more than {MOST_NUMBERS} numbers, which no sensor’s has.")
    kind = " ".join(lines["DATA"]).lower()
    kind = "binary_compressed" if kind == "binaryscompressed" else kind
    if kind not in KINDS:
        raise ReadError(
            "cloud.header", f"The PCD header’s DATA is none of {', '.join(KINDS)}: {printable(kind[:40])!r}."
        )
    points, shape, notes = _count(lines)
    return PcdHeader(tuple(fields), points, shape, _viewpoint(lines.get("VIEWPOINT", [])), kind, begin, notes)


def _lines(data: bytes) -> tuple[dict[str, list[str]], int]:
    """Return the words after the first one of each line up to DATA, and the start of the data."""
    at, words_of_key = 0, {}
    while at < min(len(data), MOST_HEADER_BYTES):
        end = data.find(b"\n", at, MOST_HEADER_BYTES)
        if end < 0:
            break
        line = data[at:end].decode("latin-1").strip()
        at = end + 1
        if line and not line.startswith("#"):
            name, *words = line.split()
            words_of_key[name.upper()] = words
            if name.upper() == "DATA":
                return words_of_key, at
    raise ReadError("cloud.header", "The file ends before a line DATA, the last of a PCD header.")


def _whole(word: str, name: str) -> int:
    if not word.isdigit() or not word.isascii() or len(word) > 18:
        text = printable(word[:40])
        raise ReadError("cloud.header", f"The PCD header’s {name} is missing or wrong: {text!r} is not a whole number.")
    return int(word)


def _count(lines: dict[str, list[str]]) -> tuple[int, tuple[int, int] | None, tuple[str, ...]]:
    """Return the number of points, height and width, and a note if they disagree: a non-zero POINTS takes
    precedence.
    """
    sizes = {name: _whole(lines[name][0], name) for name in ("WIDTH", "HEIGHT", "POINTS") if lines.get(name)}
    width, height = sizes.get("WIDTH"), sizes.get("HEIGHT", 1)
    points = sizes.get("POINTS", None if width is None else width * height)  # versions up to .6 lack POINTS
    if points == 0 and width and height:
        note = f"The header says 0 points, but its width and height {width} × {height}; the latter are taken."
        return width * height, (height, width), (note,)
    if points is None:
        raise ReadError("cloud.header", "The PCD header states no whole number of points.")
    if width is None or width * height == points:
        return points, (1, points) if width is None else (height, width), ()
    note = f"The header says {points} points, but its width and height {width} × {height}; the former is taken."
    return points, None, (note,)


def _viewpoint(words: list[str]) -> tuple[float, ...]:
    try:
        numbers = tuple(float(word) for word in words)
    except ValueError:
        numbers = ()
    return numbers if len(numbers) == 7 and all(map(math.isfinite, numbers)) else (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
