"""The units of the coordinates of a LAS file, from its projection record.

Source: the LAS specification 1.4 (records 34735 … 34737 and 2112 of LASF_Projection); the GeoTIFF specification 1.8.2
(keys 1024, 1026, 2048, 2054, 3072, 3073, 3076, 3077, 4096, 4099); OGC 01-009 and 18-010 (WKT of both versions); the
EPSG dataset for systems that files name without units. Only units are read: coordinates are not transformed between
systems, which would require pyproj and its database.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from mapper.io.clouds.epsg_units import HORIZONTAL, UNITS, VERTICAL
from mapper.io.logs.names import printable

USER = "LASF_Projection"
GEO_KEYS, GEO_DOUBLES, GEO_TEXT, WKT = 34735, 34736, 34737, 2112  #: record ids
#: Linear units by their EPSG codes.
LINEAR = {**UNITS, 9004: ("modified American foot", 0.30481225298), 9093: ("statute mile", 1609.344),
          9096: ("yard", 0.9144)}  # fmt: skip
ANGULAR = {9101: ("radian", 1.0), 9102: ("degree", math.pi / 180.0), 9105: ("grad", math.pi / 200.0)}
_MODEL, _TITLE, _GEOGRAPHIC, _ANGULAR, _PROJECTED, _NAME = 1024, 1026, 2048, 2054, 3072, 3073
_LINEAR, _LINEAR_SIZE, _UPRIGHT, _VERTICAL = 3076, 3077, 4096, 4099
_MODELS = {1: "projected", 2: "geographic", 3: "geocentric"}
#: Words for a unit in a system's title, such as "NAD83 / Oregon North (ft)", the more specific one first.
_IN_TITLES = (
    (re.compile(r"ftUS|us[- _]?ft\b|survey f(oo|ee)t", re.IGNORECASE), 9003),
    (re.compile(r"\(ft\)|\bf(oo|ee)t\b|\bift\b", re.IGNORECASE), 9002),
    (re.compile(r"\(m\)|\bmet(re|er)s?\b|\bUTM\b", re.IGNORECASE), 9001),
)
MOST_WKT = 1 << 16  #: characters
MOST_LEVELS = 40


@dataclass(frozen=True, slots=True)
class Units:
    """Units of coordinates. ``model`` is projected, geographic (longitude, latitude) or geocentric.

    ``horizontal`` and ``vertical`` are a unit's name and its size in metres; for a geographic system the first is
    degrees, or an angle's radians. ``vertical`` is None if not stated. ``unstated`` is the EPSG code of a projection
    whose record does not state its unit, which is therefore unknown.
    """

    model: str
    horizontal: tuple[str, float]
    vertical: tuple[str, float] | None = None
    unstated: int | None = None


def units_of(records: Mapping[int, bytes]) -> Units | None:
    """Return the units in the records of LASF_Projection, by record id; None if they state none.

    Text (WKT) takes precedence over GeoTIFF keys, as in LAS 1.4.
    """
    units = None
    if WKT in records:
        units = _of_wkt(records[WKT][:MOST_WKT].split(b"\0")[0].decode("utf-8", "replace"))
    if units is None and GEO_KEYS in records:
        units = _of_keys(records[GEO_KEYS], records.get(GEO_DOUBLES, b""), records.get(GEO_TEXT, b""))
    return units


def _of_keys(data: bytes, doubles: bytes, text: bytes) -> Units | None:
    numbers = struct.unpack(f"<{len(data) // 2}H", data[: len(data) // 2 * 2])
    keys: dict[int, float] = {}
    titles: dict[int, str] = {}
    for k in range(4, len(numbers) - 3, 4):
        key, place, count, value = numbers[k : k + 4]
        if place == 0:
            keys[key] = value
        elif place == GEO_DOUBLES and 8 * value + 8 <= len(doubles):
            keys[key] = struct.unpack_from("<d", doubles, 8 * value)[0]
        elif place == GEO_TEXT:
            titles[key] = text[value : value + count].decode("latin-1")
    if not keys.keys() & {_MODEL, _LINEAR, _PROJECTED, _GEOGRAPHIC}:
        return None
    is_geographic = _GEOGRAPHIC in keys and not keys.keys() & {_LINEAR, _PROJECTED}
    model = _MODELS.get(int(keys.get(_MODEL, 2 if is_geographic else 1)), "projected")
    epsg = int(keys.get(_PROJECTED, 0))
    vertical = LINEAR.get(int(keys.get(_VERTICAL, 0))) or _of_epsg(VERTICAL, int(keys.get(_UPRIGHT, 0)), epsg)
    if model == "geographic":
        return Units(model, ANGULAR.get(int(keys.get(_ANGULAR, 0)), ANGULAR[9102]), vertical)
    if model == "geocentric":
        return Units(model, LINEAR[9001], vertical)
    size = keys.get(_LINEAR_SIZE)
    code = int(keys.get(_LINEAR, 0))
    if code in LINEAR:
        return Units(model, LINEAR[code], vertical)
    if size is not None and math.isfinite(size) and size > 0.0:
        return Units(model, (f"unit of {size:g} m", size), vertical)
    title = " ".join(titles.get(key, "") for key in (_NAME, _TITLE))
    of_title = (LINEAR[unit] for words, unit in _IN_TITLES if words.search(title))
    known = _of_epsg(HORIZONTAL, epsg) or next(of_title, None)
    if known is not None:
        return Units(model, known, vertical)
    return Units(model, LINEAR[9001], vertical, epsg if 0 < epsg < 32767 else None)


def _of_epsg(table: Mapping[int, str], *numbers: int) -> tuple[str, float] | None:
    """Return the unit of the first of some EPSG systems that a table contains; None if there is none."""
    for number in numbers:
        for unit, spans in table.items():
            for first, _, last in (span.partition("-") for span in spans.split()):
                if int(first) <= number <= int(last or first):
                    return LINEAR[unit]
    return None


@dataclass(frozen=True, slots=True)
class _Node:
    """A keyword of WKT with the contents of its brackets."""

    name: str
    values: tuple[str, ...]
    inner: tuple[_Node, ...]

    def every(self) -> Iterator[_Node]:
        yield self
        for node in self.inner:
            yield from node.every()


_TOKEN = re.compile(r'"((?:[^"]|"")*)"|([A-Za-z_][A-Za-z_0-9]*)|([-+]?[0-9.][0-9.eE+-]*)|([\[\](),])')
_PROJECTED_NAMES = ("PROJCS", "PROJCRS", "PROJECTEDCRS", "LOCAL_CS", "ENGCRS", "ENGINEERINGCRS")  # or of one site
_GEOGRAPHIC_NAMES = ("GEOGCS", "GEOGCRS", "GEOGRAPHICCRS", "GEODCRS", "GEODETICCRS")
_VERTICAL_NAMES = ("VERT_CS", "VERTCS", "VERTCRS", "VERTICALCRS")
_LENGTHS = ("UNIT", "LENGTHUNIT")


def _of_wkt(text: str) -> Units | None:
    nodes = [node for root in _parsed(text) for node in root.every()]
    projected = next((node for node in nodes if node.name in _PROJECTED_NAMES), None)
    geographic = next((node for node in nodes if node.name in _GEOGRAPHIC_NAMES), None)
    upright = next((node for node in nodes if node.name in _VERTICAL_NAMES), None)
    if upright is None:
        vertical = _unit_upwards(projected or geographic)
    else:
        vertical = _unit(upright, _LENGTHS) or _of_epsg(VERTICAL, _number(upright))
    if projected is not None:
        units = _unit(projected, _LENGTHS) or _of_epsg(HORIZONTAL, _number(projected))
        return None if units is None else Units("projected", units, vertical)
    if any(node.name == "GEOCCS" or (node.name == "CS" and "Cartesian" in node.values) for node in nodes):
        return Units("geocentric", LINEAR[9001], vertical)
    if geographic is None:
        return None
    angle = _unit(geographic, ("UNIT", "ANGLEUNIT")) or ("degree", math.pi / 180.0)
    return Units("geographic", angle, vertical)


def _number(node: _Node) -> int:
    """Return the EPSG code of a system; 0 if not stated."""
    stated = next((child for child in node.inner if child.name in ("AUTHORITY", "ID")), None)
    number = stated.values[1] if stated is not None and stated.values[:1] == ("EPSG",) and stated.values[1:] else ""
    return int(number) if number.isdecimal() and len(number) < 9 else 0


def _unit_upwards(node: _Node | None) -> tuple[str, float] | None:
    """Return the unit of the upward axis of a system with three axes; None if it has none."""
    axes = [] if node is None else [child for child in node.inner if child.name == "AXIS"]
    upward = next((axis for axis in axes if "up" in (value.lower() for value in axis.values)), None)
    return None if upward is None else _unit(upward, _LENGTHS)


def _unit(node: _Node, names: tuple[str, ...]) -> tuple[str, float] | None:
    """Return the unit of a coordinate system: its own, or that of its first axis."""
    own = [child for child in node.inner if child.name in names]
    of_axes = [inner for axis in node.inner if axis.name == "AXIS" for inner in axis.inner if inner.name in names]
    for unit in (*own, *of_axes):
        try:
            size = float(unit.values[1])
        except (IndexError, ValueError):
            continue
        if math.isfinite(size) and size > 0.0:
            return printable(unit.values[0][:40]), size
    return None


def _parsed(text: str) -> list[_Node]:
    """Return the keywords of a WKT as a tree; in ESRI's the vertical system is next to the other one, not below it."""
    tokens = list(_TOKEN.finditer(text))
    place = 0

    def node(level: int) -> _Node | None:
        nonlocal place
        name = tokens[place][2].upper()
        place += 1
        values: list[str] = []
        inner: list[_Node] = []
        if place >= len(tokens) or tokens[place][4] not in ("[", "("):
            return _Node(name, (), ())
        place += 1
        while place < len(tokens) and tokens[place][4] not in ("]", ")"):
            token = tokens[place]
            follows = tokens[place + 1][4] if place + 1 < len(tokens) else ""
            if token[2] and follows in ("[", "("):
                if level >= MOST_LEVELS:
                    return None
                below = node(level + 1)
                if below is None:
                    return None
                inner.append(below)
                continue
            if token[4] != ",":
                values.append(token[1] if token[1] is not None else token[0])
            place += 1
        place += 1
        return _Node(name, tuple(values), tuple(inner))

    roots: list[_Node] = []
    while place < len(tokens):
        if tokens[place][4] == ",":
            place += 1
            continue
        root = node(1) if tokens[place][2] else None
        if root is None:
            break
        roots.append(root)
    return roots
