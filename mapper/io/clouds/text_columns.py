"""The columns of a cloud as text by their names: which of them are x, y and z, and in which unit."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

FOOT, US_FOOT = 0.3048, 1200.0 / 3937.0  #: metres
AXES = ("x", "y", "z")
_HEIGHTS = ("z", "elevation", "elev", "height", "altitude", "alt", "h", "up", "u", "z1")
DEGREES = (("longitude", "latitude"), ("lon", "lat"), ("long", "lat"), ("lng", "lat"))
#: Names, in lower case and without units, of the first two axes; with each of them z may have each name of a height.
_PLANES = (
    ("x", "y"), ("easting", "northing"), ("east", "north"), ("e", "n"), ("utm_x", "utm_y"), ("x1", "y1"), *DEGREES,
)  # fmt: skip
_AFFIXES = (
    ("p", ""), ("pos_", ""), ("position_", ""), ("position.", ""), ("point_", ""), ("point.", ""), ("coord_", ""),
    ("", "_coord"), ("", "_coordinate"), ("", "_lidar"), ("", "_world"), ("", "0"),
)  # fmt: skip
_TRIPLES = (
    *((f"{before}x{after}", f"{before}y{after}", f"{before}z{after}") for before, after in _AFFIXES),
    ("points:0", "points:1", "points:2"),
    ("points_0", "points_1", "points_2"),
    ("points_m_xyz:0", "points_m_xyz:1", "points_m_xyz:2"),  # VeloView's
)
_UNITS = {
    "m": 1.0, "metre": 1.0, "metres": 1.0, "meter": 1.0, "meters": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0,
    "ft": FOOT, "foot": FOOT, "feet": FOOT, "us-ft": US_FOOT, "usft": US_FOOT, "us_ft": US_FOOT, "ftus": US_FOOT,
    "in": 0.0254, "inch": 0.0254, "deg": 1.0, "degree": 1.0, "degrees": 1.0, "°": 1.0,
}  # fmt: skip
_BRACKETS = re.compile(r"^(.*?)[ _]*[(\[]\s*([^)\]]*?)\s*[)\]]$")
_SUFFIX = re.compile(r"^(.+?)[_ ](mm|cm|m|km|ft|feet|deg)$")
WANTED = "x, y, z; easting, northing, elevation; or longitude, latitude, altitude"


@dataclass(frozen=True, slots=True)
class Columns:
    """The numbers of the columns of x, y and z, and metres for one of their units; of degrees ``in_degrees``."""

    axes: tuple[int, int, int]
    metres: tuple[float, float, float]
    in_degrees: bool
    notes: tuple[str, ...]


def columns_of(names: Sequence[str]) -> Columns | None:
    """Return which columns are x, y and z, by their names; None where no three of them are."""
    split = [_split(name) for name in names]
    plain = [name for name, _ in split]
    found = None
    for first, second in _PLANES:
        height = next((name for name in _HEIGHTS if name in plain), None)
        if first in plain and second in plain and height is not None:
            found = (first, second, height)
            break
    if found is None:
        found = next((one for one in _TRIPLES if set(one) <= set(plain)), None)
    if found is None:
        return None
    axes = (plain.index(found[0]), plain.index(found[1]), plain.index(found[2]))
    metres = tuple(_UNITS[split[k][1] or "m"] for k in axes)
    in_degrees = found[:2] in DEGREES
    said = ", ".join(names[k] for k in axes)
    notes = [] if found == AXES or in_degrees else [f"The columns {said} are x, y, z here."]
    if set(metres) != {1.0}:
        notes = [f"The columns {said} are x, y, z here, converted to metres."]
    return Columns(axes, (metres[0], metres[1], metres[2]), in_degrees, tuple(notes))


def _split(name: str) -> tuple[str, str | None]:
    """Return a name in lower case with _ for blanks, without its unit, and the unit, where it is one that is known."""
    lower = name.strip().lower()
    for form in (_BRACKETS, _SUFFIX):
        found = form.match(lower)
        if found and found[2] in _UNITS:
            return found[1].strip().replace(" ", "_"), found[2]
    return lower.replace(" ", "_"), None
