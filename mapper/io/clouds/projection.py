"""The units of the coordinates of a LAS file, from its projection record.

Source: the LAS specification 1.4 (records 34735 … 34737 and 2112 of LASF_Projection); the GeoTIFF specification 1.8.2
(keys 1024, 2054, 3076, 3077, 4099); OGC 01-009 and 18-010 (WKT of both versions). Only units are read: no coordinates
are transformed from one system to another, for which pyproj and its database would be needed.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from mapper.io.logs.names import printable

USER = "LASF_Projection"
GEO_KEYS, GEO_DOUBLES, WKT = 34735, 34736, 2112  #: numbers of records
LINEAR = {
    9001: ("metre", 1.0), 9002: ("foot", 0.3048), 9003: ("US survey foot", 1200.0 / 3937.0),
    9004: ("modified American foot", 0.30481225298), 9005: ("Clarke's foot", 0.3047972654), 9036: ("kilometre", 1000.0),
    9093: ("statute mile", 1609.344), 9096: ("yard", 0.9144),
}  # fmt: skip
_MODEL, _ANGULAR, _LINEAR, _LINEAR_SIZE, _PROJECTED, _VERTICAL = 1024, 2054, 3076, 3077, 3072, 4099
_MODELS = {1: "projected", 2: "geographic", 3: "geocentric"}
#: EPSG's systems whose unit is the metre, as far as files leave it out: the UTM zones of WGS 84, NAD 83 and ETRS 89
_IN_METRES = (range(32601, 32661), range(32701, 32761), range(26901, 26924), range(25828, 25839), range(3857, 3858))
MOST_WKT = 1 << 16  #: characters
MOST_LEVELS = 40


@dataclass(frozen=True, slots=True)
class Units:
    """Units of coordinates. ``model`` is projected, geographic (longitude, latitude) or geocentric.

    ``horizontal`` and ``vertical`` are a unit's name and its metres; of a geographic system the first is degrees, or an
    angle's radians. ``vertical`` is None where it is not stated. ``unstated`` is the EPSG number of a projection whose
    record does not state its unit.
    """

    model: str
    horizontal: tuple[str, float]
    vertical: tuple[str, float] | None = None
    unstated: int | None = None


def units_of(records: Mapping[int, bytes]) -> Units | None:
    """Return the units in the records of LASF_Projection by their numbers; None where they state none.

    Text (WKT) counts before keys of GeoTIFF, as LAS 1.4 has it.
    """
    found = None
    if WKT in records:
        found = _of_wkt(records[WKT][:MOST_WKT].split(b"\0")[0].decode("utf-8", "replace"))
    if found is None and GEO_KEYS in records:
        found = _of_keys(records[GEO_KEYS], records.get(GEO_DOUBLES, b""))
    return found


def _of_keys(data: bytes, doubles: bytes) -> Units | None:
    numbers = struct.unpack(f"<{len(data) // 2}H", data[: len(data) // 2 * 2])
    keys: dict[int, float] = {}
    for k in range(4, len(numbers) - 3, 4):
        key, place, _, value = numbers[k : k + 4]
        if place == 0:
            keys[key] = value
        elif place == GEO_DOUBLES and 8 * value + 8 <= len(doubles):
            keys[key] = struct.unpack_from("<d", doubles, 8 * value)[0]
    if _MODEL not in keys and _LINEAR not in keys:
        return None
    model = _MODELS.get(int(keys.get(_MODEL, 1)), "projected")
    vertical = LINEAR.get(int(keys.get(_VERTICAL, 0)))
    if model == "geographic":
        return Units(model, ("degree", math.pi / 180.0), vertical)
    size = keys.get(_LINEAR_SIZE)
    code = int(keys.get(_LINEAR, 0))
    if code in LINEAR:
        return Units(model, LINEAR[code], vertical)
    if size is not None and math.isfinite(size) and size > 0.0:
        return Units(model, (f"unit of {size:g} m", size), vertical)
    epsg = int(keys.get(_PROJECTED, 0))
    unstated = epsg if 0 < epsg < 32767 and not any(epsg in one for one in _IN_METRES) else None
    return Units(model, LINEAR[9001], vertical, unstated)


@dataclass(frozen=True, slots=True)
class _Node:
    """A keyword of WKT with what stands in its brackets."""

    name: str
    values: tuple[str, ...]
    inner: tuple[_Node, ...]

    def every(self) -> Iterator[_Node]:
        yield self
        for one in self.inner:
            yield from one.every()


_TOKEN = re.compile(r'"((?:[^"]|"")*)"|([A-Za-z_][A-Za-z_0-9]*)|([-+]?[0-9.][0-9.eE+-]*)|([\[\](),])')
_PROJECTED_NAMES = ("PROJCS", "PROJCRS", "PROJECTEDCRS")
_GEOGRAPHIC_NAMES = ("GEOGCS", "GEOGCRS", "GEOGRAPHICCRS", "GEODCRS", "GEODETICCRS")
_VERTICAL_NAMES = ("VERT_CS", "VERTCS", "VERTCRS", "VERTICALCRS")
_LENGTHS = ("UNIT", "LENGTHUNIT")


def _of_wkt(text: str) -> Units | None:
    root = _parsed(text)
    if root is None:
        return None
    nodes = list(root.every())
    upright = next((one for one in nodes if one.name in _VERTICAL_NAMES), None)
    vertical = None if upright is None else _unit(upright, _LENGTHS)
    projected = next((one for one in nodes if one.name in _PROJECTED_NAMES), None)
    if projected is not None:
        found = _unit(projected, _LENGTHS)
        return None if found is None else Units("projected", found, vertical)
    if any(one.name == "GEOCCS" or (one.name == "CS" and "Cartesian" in one.values) for one in nodes):
        return Units("geocentric", LINEAR[9001], vertical)
    geographic = next((one for one in nodes if one.name in _GEOGRAPHIC_NAMES), None)
    if geographic is None:
        return None
    angle = _unit(geographic, ("UNIT", "ANGLEUNIT")) or ("degree", math.pi / 180.0)
    return Units("geographic", angle, vertical)


def _unit(node: _Node, names: tuple[str, ...]) -> tuple[str, float] | None:
    """Return the unit of a coordinate system: of its own, or of its first axis."""
    own = [one for one in node.inner if one.name in names]
    of_axes = [inner for one in node.inner if one.name == "AXIS" for inner in one.inner if inner.name in names]
    for one in (*own, *of_axes):
        try:
            size = float(one.values[1])
        except (IndexError, ValueError):
            continue
        if math.isfinite(size) and size > 0.0:
            return printable(one.values[0][:40]), size
    return None


def _parsed(text: str) -> _Node | None:
    """Return the first keyword of a WKT with all below it; None for a text that is none."""
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

    return node(1) if tokens and tokens[0][2] else None
