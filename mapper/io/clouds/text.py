"""Point clouds as text: XYZ, PTS and CSV, with or without a line of names.

Names are those of libpointmatcher and CloudCompare: x, y, z, nx, ny, nz, intensity, r, g, b, and others known to
:func:`columns_of`. Without names the columns are x, y, z and what programs usually write next: an intensity, a normal
(of length 1), a colour, in several orders. A PTS file may contain several scans, each after its number of points.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ReadError
from mapper.core.limits import Limits
from mapper.io.clouds.content import ended_early, made_cloud
from mapper.io.clouds.degrees import have_steps_of_degrees, metres_of_degrees
from mapper.io.clouds.numbers import CONTENT, as_python_writes, table
from mapper.io.clouds.text_layout import SAMPLE_LINES, Layout, columns_of_words, layout_of
from mapper.io.logs.names import printable
from mapper.sensors.point_cloud import PointCloud

FOOT, US_FOOT = 0.3048, 1200.0 / 3937.0  #: metres
AXES = ("x", "y", "z")
_HEIGHTS = ("z", "elevation", "elev", "height", "altitude", "alt", "h", "up", "u", "z1", "höhe", "hoehe")
DEGREES = (("longitude", "latitude"), ("lon", "lat"), ("long", "lat"), ("lng", "lat"))
#: Names, in lower case and without units, of the first two axes; z may have any name of a height.
_PLANES = (
    ("x", "y"), ("easting", "northing"), ("east", "north"), ("e", "n"), ("utm_x", "utm_y"), ("x1", "y1"),
    ("rechtswert", "hochwert"), ("ost", "nord"), *DEGREES,
)  # fmt: skip
_AFFIXES = (
    ("p", ""), ("pos_", ""), ("position_", ""), ("position.", ""), ("point_", ""), ("point.", ""), ("coord_", ""),
    ("", "_coord"), ("", "_coordinate"), ("", "_lidar"), ("", "_world"), ("", "0"), ("field.", ""), ("world_", ""),
)  # fmt: skip
_TRIPLES = (
    *((f"{before}x{after}", f"{before}y{after}", f"{before}z{after}") for before, after in _AFFIXES),
    ("points:0", "points:1", "points:2"),
    ("points_0", "points_1", "points_2"),
    ("xyz_0", "xyz_1", "xyz_2"),
    ("points_m_xyz:0", "points_m_xyz:1", "points_m_xyz:2"),  # VeloView's
)
_UNITS = {
    "m": 1.0, "metre": 1.0, "metres": 1.0, "meter": 1.0, "meters": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0,
    "ft": FOOT, "foot": FOOT, "feet": FOOT,
    **dict.fromkeys(("us-ft", "usft", "us_ft", "us ft", "ftus", "survey feet", "us survey ft", "us survey foot",
                     "us survey feet"), US_FOOT),
    "in": 0.0254, "inch": 0.0254, "deg": 1.0, "degree": 1.0, "degrees": 1.0, "°": 1.0,
}  # fmt: skip
_BRACKETS = re.compile(r"^(.*?)[ _]*[(\[]\s*([^)\]]*?)\s*[)\]]$")
_SUFFIX = re.compile(r"^(.+?)[_ /](mm|cm|m|km|ft|feet|deg)$")
WANTED = "x, y, z; easting, northing, elevation; or longitude, latitude, altitude"


@dataclass(frozen=True, slots=True)
class Columns:
    """The indices of the columns of x, y and z, and the metres per unit; ``in_degrees`` for degrees."""

    axes: tuple[int, int, int]
    metres: tuple[float, float, float]
    in_degrees: bool
    notes: tuple[str, ...]


def columns_of(names: Sequence[str]) -> Columns | None:
    """Return which columns are x, y and z, by their names; None if there are no such three."""
    split = [_split(name) for name in names]
    plain = [name for name, _ in split]
    columns = None
    for first, second in _PLANES:
        height = next((name for name in _HEIGHTS if name in plain), None)
        if first in plain and second in plain and height is not None:
            columns = (first, second, height)
            break
    if columns is None:
        columns = next((triple for triple in _TRIPLES if set(triple) <= set(plain)), None)
    if columns is None:
        return None
    axes = (plain.index(columns[0]), plain.index(columns[1]), plain.index(columns[2]))
    metres = tuple(_UNITS[split[k][1] or "m"] for k in axes)
    in_degrees = columns[:2] in DEGREES
    axes_text = ", ".join(names[k] for k in axes)
    notes = [] if columns == AXES or in_degrees else [f"The columns {axes_text} are x, y, z here."]
    if set(metres) != {1.0}:
        notes = [f"The columns {axes_text} are x, y, z here, converted to metres."]
    return Columns(axes, (metres[0], metres[1], metres[2]), in_degrees, tuple(notes))


def _split(name: str) -> tuple[str, str | None]:
    """Return a name in lower case with _ for blanks, without its unit, and the unit, if it is known."""
    lower = name.strip()[:LONGEST_NAME].lower()
    for form in (_BRACKETS, _SUFFIX):
        match = form.match(lower)
        if match and match[2] in _UNITS:
            return match[1].strip().replace(" ", "_"), match[2]
    return lower.replace(" ", "_"), None


MOST_LINE_BYTES = 1 << 14
LEAST_COUNTED = 10  #: lines needed to recognise their first numbers as line counts
COUNTED = ("The first column counts the points, so the next three are x, y, z here.",)
COLOURS, NORMALS = ("r", "g", "b"), ("nx", "ny", "nz")
_COUNT = re.compile(rb"^[ \t]*(\d{1,18})[ \t]*\r?$", re.MULTILINE)
_ANY_NUMBERS = re.compile(rb"(?=[^\d]*\d)[-+.,;|\s\deE]+")
_SIGNS = {"\u2212".encode(): b"-", "\u00a0".encode(): b" ", "\u202f".encode(): b" "}
_LETTER = re.compile(r"[^\W\d_]")
_NAME_SEPARATORS = (",", ";", "|", "\t")
LONGEST_NAME = 200  #: examined characters of a column's name, because the patterns of units take quadratic time
MOST_LINES_BEFORE = 40  #: before the names of the columns


@dataclass(frozen=True, slots=True)
class _Beginning:
    """What precedes the numbers: ``names`` of the columns, number of points.

    ``at`` and ``line`` are the byte offset and the number of the first line of numbers. ``others`` are lines before the
    names that are neither comments nor numbers.
    """

    at: int
    line: int
    names: tuple[str, ...] | None
    claimed: int | None
    others: int = 0


def names_of(line: bytes) -> tuple[str, ...] | None:
    """Return the names of the columns in a line; None for a line with a number.

    They are separated by commas, semicolons or tabs if the line has one, else by blanks; a unit in brackets is part of
    the name before it.
    """
    try:
        text = line.decode()
    except UnicodeDecodeError:
        text = line.decode("cp1252", "replace")
    text = text.strip().lstrip("#/% \t").strip()
    separator = next((name_separator for name_separator in _NAME_SEPARATORS if name_separator in text), None)
    if separator is None:
        text = re.sub(r"[ \t]+(?=[(\[])", "\0", text)
        words = [word.replace("\0", " ") for word in text.split()]
    else:
        words = text.rstrip(separator + " ").split(separator)
    names = tuple(word.strip(" \"'\r") for word in words)
    named = [name for name in names if name]  # that of a table's index is empty
    if not named or any(_LETTER.search(name) is None or _is_number(name.replace(",", ".")) for name in named):
        return None
    return names


def looks_like_text(data: bytes) -> bool:
    """Return whether a file that starts with ``data`` is a cloud as text: names with x, y, z, or a line of numbers.

    Numbers below other names also count, so that the reader can report the required names.
    """
    data = _tidied(data[:MOST_LINE_BYTES])
    begin = _beginning(data)
    lines = data[begin.at :].split(b"\n")
    first = next((line for line in lines if line.strip()), b"")
    if begin.names is not None and columns_of(begin.names) is not None:
        return True
    try:
        layout = layout_of(lines[: max(1, len(lines) - 1)])
    except ReadError:
        return True
    numbers = layout.numbers(first)
    if numbers is None or len(numbers) < (3 if begin.names is None else 2):
        return False
    return begin.names is None or len(begin.names) == len(numbers)


def _beginning(data: bytes) -> _Beginning:
    at, number, names, claimed = 0, 1, None, None
    others = _lines_before_names(data)
    for _ in range(others):
        at, number = data.find(b"\n", at) + 1, number + 1
    while at < len(data):
        end = data.find(b"\n", at)
        end = len(data) if end < 0 else end
        line = data[at : min(end, at + MOST_LINE_BYTES)]
        labels = names_of(line)
        is_remark = line.lstrip().startswith((b"#", b"//", b"%")) or (names is not None and _is_rule(line))
        count = _COUNT.fullmatch(line)
        if labels is not None and names is not None and len(labels) == len(names) and _are_units(labels):
            names = tuple(f"{name} ({unit.strip('()[]')})" for name, unit in zip(names, labels, strict=True))
        elif labels is not None and (columns_of(labels) is not None or not (is_remark or names)):
            if names is not None and columns_of(labels) is None:
                break
            names = labels
        elif count is not None and claimed is None:
            claimed = int(count[1])
        elif line.strip() and not is_remark:
            break
        at, number = end + 1, number + 1
    return _Beginning(min(at, len(data)), number, names, claimed, others)


def _lines_before_names(data: bytes) -> int:
    """Return the number of lines of other content, without numbers, before one that names columns of x, y and z.

    0 if numbers come first, there are only comments and counts, or no such names.
    """
    others = False
    for k, line in enumerate(data[: 4 * MOST_LINE_BYTES].split(b"\n")[:MOST_LINES_BEFORE]):
        names = names_of(line)
        if names is not None and columns_of(names) is not None:
            return k if others else 0
        numbers = _ANY_NUMBERS.fullmatch(line)
        if numbers and _COUNT.fullmatch(line) is None:
            return 0
        others = others or bool(line.strip() and not numbers and not line.lstrip().startswith((b"#", b"//", b"%")))
    return 0


def _tidied(data: bytes) -> bytes:
    """Return a text without the trailing content of some programs, and with similar signs replaced by minus and
    blank.
    """
    if data.endswith((b"\0", b"\x1a")):
        data = data.rstrip(b"\0\x1a")
    for sign, plain in _SIGNS.items():
        if sign in data:
            data = data.replace(sign, plain)
    return data


def _is_rule(line: bytes) -> bool:
    """Return whether a line below names is a rule, as drawn by psql and Markdown."""
    return b"--" in line and not line.strip(b"-:|+ \t\r")


def _are_units(words: Sequence[str]) -> bool:
    """Return whether words are units of lengths and angles, as some programs write them below the column names."""
    return all(word.strip("()[] ").lower() in _UNITS for word in words)


def read_text(data: bytes, limits: Limits) -> PointCloud:
    """Return the points of a text file. Raises :class:`ReadError`, naming the line, and :class:`LimitError`."""
    data = _tidied(data)
    begin = _beginning(data)
    columns = None if begin.names is None else columns_of(begin.names)
    if begin.names is not None and columns is None:
        has = printable(", ".join(begin.names)[:200])
        raise ReadError(
            "cloud.columns", f"The columns are named {has}; a cloud needs {WANTED}, and the file is not a log of scans."
        )
    text = data[begin.at :]
    sample = [line for line in _first_lines(text) if line.strip() and not line.lstrip().startswith(b"#")]
    layout = layout_of(sample)
    words: tuple[int, ...] = ()
    if begin.names is not None and columns is not None:
        if all(line.count(b"\t") == len(begin.names) - 1 for line in sample):
            layout = replace(layout, separator="\t")
        words = tuple(k for k in columns_of_words(sample, layout) if k not in columns.axes)
        layout = replace(layout, words=words)
    rows, notes = _rows(text, begin, layout, limits)
    if len(rows) == 0:
        return made_cloud(np.zeros((0, 3)), {}, limits)
    if rows.shape[1] < len(AXES):
        raise ReadError("cloud.columns", f"A point needs three numbers, and the lines have {rows.shape[1]}.")
    names = begin.names
    if names is None or columns is None:
        _refuse_matrix(rows)
        counted = _are_numbers_of_points(rows)
        names = ("number", *_usual_names(rows[:, 1:])) if counted else tuple(_usual_names(rows))
        first = int(counted)
        columns = Columns((first, first + 1, first + 2), (1.0, 1.0, 1.0), in_degrees=False, notes=COUNTED * first)
    elif len(names) + 1 == rows.shape[1] and _count_up(rows[:, 0]):  # R leaves out the name of a table's first column
        names = ("", *names)
        columns = replace(columns, axes=(columns.axes[0] + 1, columns.axes[1] + 1, columns.axes[2] + 1))
    elif len(names) != rows.shape[1]:
        raise ReadError("cloud.columns", f"The lines have {rows.shape[1]} numbers, but {len(names)} column names.")
    points = rows[:, list(columns.axes)] * columns.metres
    notes = (*notes, *columns.notes)
    if begin.others:
        lines = "1 line" if begin.others == 1 else f"{begin.others} lines"
        notes = (*notes, f"Text before the column names is skipped: {lines}.")
    if words:
        listed = ", ".join(printable(names[k][:100]) for k in words[:6])
        notes = (*notes, f"Columns with other things than numbers are left out: {listed}.")
    if columns.in_degrees:
        points[:, :2], note = metres_of_degrees(points[:, :2], "The columns are longitude and latitude in degrees")
        notes = (*notes, note)
    elif set(columns.metres) == {1.0} and _look_like_degrees(points, steps := _steps(sample, layout, columns)):
        why = (
            f"The first two coordinates have steps of {steps[0]:g} and the third of {steps[2]:g}, as longitude, "
            "latitude and a height have"
        )
        points[:, :2], note = metres_of_degrees(points[:, :2], why)
        notes = (*notes, note)
    others = {printable(name[:100]): rows[:, k] for k, name in enumerate(names) if k not in (*columns.axes, *words)}
    return made_cloud(points, others, limits, notes=notes)


def _rows(
    text: bytes, begin: _Beginning, layout: Layout, limits: Limits
) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """Return the numbers (rows, columns), and notes on a file that ends early."""
    if begin.claimed is None:
        plain = layout.plain(text)
        whole = _whole_lines(plain)
        cut: tuple[str, ...] = ()
        if whole is not plain:
            cut = ("The file ends within its last line, which is left out.",)
        return table(whole, None, None, None, limits, begin.line), cut
    parts, there, claimed, more, line = [], 0, 0, 0, begin.line
    for n, block in _scans(text, begin.claimed):
        rows = table(layout.plain(block), None, n, None, limits, line)
        parts.append(rows)
        there, claimed, line = there + len(rows), claimed + n, line + block.count(b"\n") + 1
        more += max(0, len(CONTENT.findall(block)) - n)
    widths = {part.shape[1] for part in parts if len(part)}
    if len(widths) > 1:
        raise ReadError("cloud.numbers", "The scans of the file have different numbers of columns.")
    notes = ended_early(claimed, there)
    if more:
        notes = (*notes, f"{more} more lines than the header says, {claimed}, are left out.")
    if len(parts) > 1:
        notes = (f"The file holds {len(parts)} scans, which are one cloud here.", *notes)
    return np.concatenate([part for part in parts if len(part)]) if there else np.zeros((0, 0)), notes


def _scans(text: bytes, first: int) -> Iterator[tuple[int, bytes]]:
    """Yield the number of points and the lines of each scan; ``first`` is the number of points of the first scan."""
    at, n = 0, first
    for match in _COUNT.finditer(text):
        yield n, text[at : match.start()]
        at, n = match.end(), int(match[1])
    yield n, text[at:]


def _whole_lines(text: bytes) -> bytes:
    """Return a text without an incomplete last line, which has fewer numbers than the first one."""
    last = text.rfind(b"\n") + 1
    if last == 0 or last == len(text):
        return text
    first = next((line for line in _first_lines(text) if line.strip() and not line.startswith(b"#")), b"")
    return text[:last] if 0 < len(text[last:].split()) < len(first.split()) else text


def _first_lines(text: bytes) -> list[bytes]:
    """Return the first complete lines of a text."""
    lines = text[: SAMPLE_LINES * 256].split(b"\n")
    return lines[: -1 if len(lines) > 1 else None][:SAMPLE_LINES]


def _refuse_matrix(rows: NDArray[np.float64]) -> None:
    """Raise :class:`ReadError` for the matrix of a camera's intrinsics (3, 3) or of a pose (4, 4).

    Folders of depth images have files of both, whose lines look like points.
    """
    size = len(rows)
    if rows.shape != (size, size) or size not in (3, 4) or rows[-1].tolist() != [0.0] * (size - 1) + [1.0]:
        return
    if size == 3 and rows[1, 0] == 0.0 and (rows[[0, 1], [0, 1]] > 0.0).all():
        raise ReadError(
            "cloud.intrinsics",
            "The file holds the 3 × 3 matrix of a camera’s intrinsics, no points; open the folder of depth images that "
            "it belongs to.",
        )
    if size == 4 and np.allclose(rows[:3, :3] @ rows[:3, :3].T, np.eye(3), atol=1e-3):
        raise ReadError(
            "cloud.pose",
            "The file holds the 4 × 4 matrix of a pose, no points; open the folder of images that it belongs to.",
        )


def _are_numbers_of_points(rows: NDArray[np.float64]) -> bool:
    """Return whether the first of at least four columns counts the lines, and others are not integers."""
    n, width = rows.shape
    if n < LEAST_COUNTED or width <= len(AXES) or not _count_up(rows[:, 0]):
        return False
    return bool((rows[:, 1:4] != np.round(rows[:, 1:4])).any(axis=0).all())


def _count_up(column: NDArray[np.float64]) -> bool:
    """Return whether a column counts its rows by ones."""
    return bool(column[0] >= 0.0 and len(column) > 1 and (np.diff(column) == 1.0).all())


def _steps(lines: Sequence[bytes], layout: Layout, columns: Columns) -> tuple[float, float, float]:
    """Return the resolutions of x, y and z, from their decimals; infinite for one with exponents."""
    decimals = [0.0, 0.0, 0.0]
    for words in (layout.plain(line).split() for line in lines):
        for k, axis in enumerate(columns.axes):
            word = words[axis] if axis < len(words) else b""
            after = word.partition(b".")[2]
            decimals[k] = max(decimals[k], len(after) if after.isdigit() or not after else -math.inf)
            if after and not after.isdigit():
                return (math.inf, math.inf, math.inf)
    return (10.0 ** -decimals[0], 10.0 ** -decimals[1], 10.0 ** -decimals[2])


def _look_like_degrees(points: NDArray[np.float64], steps: Sequence[float]) -> bool:
    """Return whether coordinates without stated units are longitude, latitude and a height in metres.

    They have such resolutions, and the range of the heights, in metres, is more than ten times that of the degrees.
    """
    known = points[np.isfinite(points).all(axis=1)]
    if not have_steps_of_degrees(known, steps):
        return False
    extent = np.ptp(known, axis=0)
    return bool(extent[2] > 10.0 * max(extent[0], extent[1]) > 0.0)


def _usual_names(rows: NDArray[np.float64]) -> list[str]:
    """Return names for unnamed columns: those that programs usually write after x, y and z, if they fit."""
    more = rows[:, 3:]
    for names in _USUAL:
        if len(names) == more.shape[1] and all(
            may_be(more[:, [names.index(part) for part in parts]])
            for parts, may_be in ((COLOURS, _are_colours), (NORMALS, _are_normals))
            if parts[0] in names
        ):
            return [*AXES, *names]
    return [*AXES, *(f"column {k + 4}" for k in range(more.shape[1]))]


_ONE = ("intensity",)
_USUAL = (
    _ONE, NORMALS, COLOURS, (*_ONE, *COLOURS), (*_ONE, *NORMALS), (*COLOURS, *_ONE), (*NORMALS, *_ONE),
    (*COLOURS, *NORMALS), (*NORMALS, *COLOURS), (*_ONE, *COLOURS, *NORMALS), (*COLOURS, *NORMALS, *_ONE),
)  # fmt: skip


def _are_colours(columns: NDArray[np.float64]) -> bool:
    """Return whether three columns are integers of one byte, or fractions of 1."""
    if not ((columns >= 0.0) & (columns <= 255.0)).all():
        return False
    most = columns.max(initial=0.0)
    return bool(most <= 1.0 or (columns == np.round(columns)).all())


def _are_normals(columns: NDArray[np.float64]) -> bool:
    """Return whether three columns are vectors of length 1, or 0 for none."""
    length = np.linalg.norm(columns, axis=1)
    return bool(((np.abs(length - 1.0) < 0.02) | (length == 0.0) | np.isnan(length)).all() and length.any())


def _is_number(word: str) -> bool:
    try:
        float(as_python_writes(word.encode()))
    except ValueError:
        return False
    return True
