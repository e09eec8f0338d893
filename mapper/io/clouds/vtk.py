"""Point clouds in VTK's legacy format, ascii or binary, as written by libpointmatcher.

Source: "VTK File Formats" (legacy), and PointMatcherIO of libpointmatcher: the points of a POLYDATA or an
UNSTRUCTURED_GRID, and their POINT_DATA. A 64-bit time is stored in two columns of 32 bits, ``NAME_splitTime_high32``
and ``NAME_splitTime_low32``, nanoseconds.
"""

from __future__ import annotations

import re
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ReadError
from mapper.core.limits import Limits
from mapper.io.clouds.content import check_count, made_cloud
from mapper.io.logs.names import printable
from mapper.sensors.point_cloud import PointCloud

MOST_LINE_BYTES = 1 << 12
MOST_COUNT = 1 << 48  #: so that products of counts fit into 64-bit integers
TYPES = {
    "bit": "u1", "char": "i1", "unsigned_char": "u1", "short": "i2", "unsigned_short": "u2", "int": "i4",
    "unsigned_int": "u4", "long": "i8", "unsigned_long": "u8", "float": "f4", "double": "f8", "vtkIdType": "i8",
    "vtktypeint64": "i8", "vtktypeuint64": "u8",
}  # fmt: skip
CELLS = ("VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS", "CELLS")
HIGH, LOW = "_splitTime_high32", "_splitTime_low32"
#: A line that starts with a letter, except the numbers nan and inf.
KEYWORD = re.compile(rb"\n[ \t]*(?!(?:nan|inf)\b)[A-Za-z_]", re.IGNORECASE)


def read_vtk(data: bytes, limits: Limits) -> PointCloud:
    """Return the points of a legacy VTK file and their fields. Raises :class:`ReadError`."""
    reader = _Reader(data, limits)
    reader.read()
    columns = dict(reader.columns)
    for name in [name for name in columns if name.endswith(HIGH)]:
        whole = name.removesuffix(HIGH)
        if whole + LOW in columns:
            high, low = columns.pop(name).astype(np.uint64), columns.pop(whole + LOW).astype(np.uint64)
            columns[whole] = ((high << np.uint64(32)) | low).astype(np.int64)
    return made_cloud(reader.points, columns, limits)


class _Reader:
    """Processes the file section by section."""

    def __init__(self, data: bytes, limits: Limits) -> None:
        self._data, self._limits = data, limits
        self._at = 0
        self._is_ascii = True
        self.points: NDArray[Any] = np.zeros((0, 3))
        self.columns: dict[str, NDArray[Any]] = {}

    def read(self) -> None:
        """Read all sections."""
        if not self._line().startswith("# vtk DataFile"):
            raise ReadError("cloud.header", "The file is not a legacy VTK file: its first line must be # vtk DataFile.")
        self._line()  # the title
        kind = self._line().strip().upper()
        if kind not in ("ASCII", "BINARY"):
            raise ReadError("cloud.header", f"A VTK file must be ASCII or BINARY, not {printable(kind[:40])!r}.")
        self._is_ascii = kind == "ASCII"
        has_points = of_points = False
        while self._at < len(self._data):
            words = self._line().split()
            if not words:
                continue
            key = words[0].upper()
            if key == "POINTS":
                n = self._count(words, 1)
                check_count(n, self._limits)
                self.points = self._numbers(3 * n, words[2:3], "the points").reshape(n, 3)
                has_points = True
            elif key in CELLS:
                self._numbers(self._count(words, 2), ["int"], key)
            elif key == "CELL_TYPES":
                self._numbers(self._count(words, 1), ["int"], key)
            elif key in ("POINT_DATA", "CELL_DATA"):
                of_points = key == "POINT_DATA"
                if of_points and self._count(words, 1) != len(self.points):
                    raise ReadError(
                        "cloud.header", f"POINT_DATA is of {words[1]} points, but the file has {len(self.points)}."
                    )
            elif of_points:
                self._attribute(key, words)
            elif key not in ("DATASET", "METADATA") and has_points:
                return  # of cells, which are not needed
        if not has_points:
            raise ReadError("cloud.header", "The VTK file has no section POINTS.")

    def _attribute(self, key: str, words: list[str]) -> None:
        n = len(self.points)
        name = printable(words[1][:100]) if len(words) > 1 else ""
        if key == "SCALARS":
            components = self._count(words, 3) if len(words) > 3 else 1
            before = self._at
            if not self._line().upper().startswith("LOOKUP_TABLE"):
                self._at = before
            values = self._numbers(components * n, words[2:3], name)
        elif key in ("VECTORS", "NORMALS", "TENSORS", "TEXTURE_COORDINATES"):
            components = {"TENSORS": 9, "TEXTURE_COORDINATES": 0}.get(key, 3) or self._count(words, 2)
            values = self._numbers(components * n, words[-1:], name)
        elif key == "COLOR_SCALARS":
            components = self._count(words, 2)
            values = self._numbers(components * n, ["float" if self._is_ascii else "unsigned_char"], name)
        elif key == "LOOKUP_TABLE":
            self._numbers(4 * self._count(words, 2), ["float" if self._is_ascii else "unsigned_char"], name)
            return
        elif key == "FIELD":
            for _ in range(self._count(words, 2)):
                stated = self._line().split() or self._line().split()
                width, rows = self._count(stated, 1), self._count(stated, 2)
                values = self._numbers(width * rows, stated[3:4], stated[0])
                if rows == n:
                    self.columns[printable(stated[0][:100])] = values.reshape(n, width) if width > 1 else values
            return
        elif key == "METADATA":
            return
        else:
            raise ReadError("cloud.damaged", f"At byte {self._at}: {printable(key[:40])!r} is not a VTK section.")
        if components not in (1, 3, 4) or key == "TENSORS":
            self.columns[name] = values.reshape(n, components)
        elif key == "NORMALS" or name.lower() == "normals":
            self._split(("normal_x", "normal_y", "normal_z"), values.reshape(n, components))
        elif key == "COLOR_SCALARS":
            self._split(("red", "green", "blue"), values.reshape(n, components)[:, :3])
        else:
            self.columns[name] = values if components == 1 else values.reshape(n, components)

    def _split(self, names: tuple[str, str, str], values: NDArray[Any]) -> None:
        if values.shape[1] < len(names):
            raise ReadError("cloud.damaged", f"{names[0]} and its neighbours have {values.shape[1]} numbers, not 3.")
        for k, name in enumerate(names):
            self.columns[name] = np.ascontiguousarray(values[:, k])

    def _line(self) -> str:
        end = self._data.find(b"\n", self._at, self._at + MOST_LINE_BYTES)
        if end < 0:
            end = min(len(self._data), self._at + MOST_LINE_BYTES)
        line = self._data[self._at : end]
        self._at = end + 1
        return line.decode("latin-1").rstrip("\r")

    def _count(self, words: list[str], at: int) -> int:
        try:
            count = int(words[at])
        except (IndexError, ValueError):
            count = -1
        if not 0 <= count <= MOST_COUNT:
            text = printable(" ".join(words)[:60])
            raise ReadError("cloud.header", f"At byte {self._at}: the line {text!r} states no possible count.")
        return count

    def _numbers(self, n: int, kind: list[str], what: str) -> NDArray[Any]:
        """Return the next ``n`` numbers of a type."""
        code = TYPES.get(kind[0]) if kind else None
        if code is None:
            text = printable(kind[0][:40]) if kind else ""
            raise ReadError("cloud.header", f"{printable(what[:40])} is of the type {text!r}, which VTK does not have.")
        if not self._is_ascii:
            dtype = np.dtype(">" + code)
            if self._at + n * dtype.itemsize > len(self._data):
                raise ReadError("cloud.truncated", f"The file ends early, within {printable(what[:40])}.")
            values = np.frombuffer(self._data, dtype, n, self._at)
            self._at += n * dtype.itemsize
            return values.astype(dtype.newbyteorder("="))
        following = KEYWORD.search(self._data, max(0, self._at - 1))
        end = len(self._data) if following is None else following.start() + 1
        block = self._data[self._at : end]
        self._at = end
        values = _parsed(block, what)
        if len(values) != n:
            few = "ends early" if len(values) < n else "is damaged"
            raise ReadError(
                "cloud.truncated", f"The file {few}: {printable(what[:40])} must be {n} numbers, not {len(values)}."
            )
        return _as_type(values, code, what)


def _as_type(values: NDArray[np.float64], code: str, what: str) -> NDArray[Any]:
    """Convert the numbers of a text to the type stated by the file; overflow in float32 becomes infinite."""
    if code[0] == "f":
        with np.errstate(over="ignore"):
            return values.astype(code)
    limits = np.iinfo(code)
    if not ((values >= limits.min) & (values < limits.max + 1)).all():  # also rejects NaN
        raise ReadError("cloud.damaged", f"{printable(what[:40])} has a number that does not fit its type.")
    return values.astype(code)


def _parsed(block: bytes, what: str) -> NDArray[np.float64]:
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # NumPy's report of invalid text
        try:
            return np.fromstring(block.decode("latin-1"), dtype=np.float64, sep=" ")
        except (DeprecationWarning, ValueError) as error:
            raise ReadError("cloud.numbers", f"Something in {printable(what[:40])} is not a number.") from error
