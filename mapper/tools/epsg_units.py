"""``python -m mapper.tools.epsg_units PROJ.DB``: print :mod:`mapper.io.clouds.epsg_units`.

PROJ.DB is the database of PROJ (proj.db, SQLite), which contains the EPSG dataset. The units of a compound system are
those of its two parts. Codes with the same unit are joined into spans if no system with another unit, or with
coordinates that are not lengths, has a code in between. Codes from 32767 on do not denote a system in a projection
record.
"""

from __future__ import annotations

import sqlite3
import sys
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing

USER_DEFINED = 32767  #: the record itself defines its system
_HEAD = '''"""Units of the projected and the vertical systems of the EPSG dataset {version} of {date}, by their numbers.

Written by ``python -m mapper.tools.epsg_units`` from the database of PROJ {proj}; not edited by hand.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
'''
_AXIS = (
    "SELECT CAST(c.code AS INT), CAST(a.uom_code AS INT) FROM {table} c JOIN axis a ON a.coordinate_system_auth_name = "
    "c.coordinate_system_auth_name AND a.coordinate_system_code = c.coordinate_system_code "
    "WHERE c.auth_name = 'EPSG' AND a.coordinate_system_order = 1"
)
_COMPOUND = (
    "SELECT CAST(code AS INT), CAST(horiz_crs_code AS INT), CAST(vertical_crs_code AS INT) FROM compound_crs "
    "WHERE auth_name = 'EPSG' AND horiz_crs_auth_name = 'EPSG' AND vertical_crs_auth_name = 'EPSG'"
)
_UNITS = "SELECT CAST(code AS INT), name, conv_factor FROM unit_of_measure WHERE auth_name = 'EPSG' AND type = 'length'"


def spans_of(units: Mapping[int, int], numbers: Iterable[int]) -> dict[int, list[tuple[int, int]]]:
    """Return the spans of codes (first, last) of each unit; ``numbers`` are the codes of all systems."""
    spans: dict[int, list[tuple[int, int]]] = {}
    before = None
    for number in sorted(numbers):
        unit = units.get(number)
        if unit is not None:
            of_unit = spans.setdefault(unit, [])
            first = of_unit.pop()[0] if unit == before else number
            of_unit.append((first, number))
        before = unit
    return dict(sorted(spans.items()))


def _written(name: str, remark: str, spans: Mapping[int, list[tuple[int, int]]]) -> Iterator[str]:
    yield f"#: {remark}"
    yield f"{name}: Mapping[int, str] = MappingProxyType({{"
    for unit, of_unit in spans.items():
        text = " ".join(f"{first}-{last}" if last > first else f"{first}" for first, last in of_unit)
        lines = textwrap.wrap(text, 104, break_on_hyphens=False)
        quoted = [f'"{line} "' for line in lines[:-1]] + [f'"{lines[-1]}"']
        yield f"    {unit}: {quoted[0]}," if len(quoted) == 1 else f"    {unit}: ("
        if len(quoted) > 1:
            yield from (f"        {line}" for line in quoted)
            yield "    ),"
    yield "})"


def module_text(path: str) -> str:
    """Return the text of the module for the database at ``path``."""
    with closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as database:
        kinds = ("projected_crs", "vertical_crs", "geodetic_crs")
        projected, vertical, geodetic = (dict(database.execute(_AXIS.format(table=kind))) for kind in kinds)
        compound = database.execute(_COMPOUND).fetchall()
        sizes = {code: (name, size) for code, name, size in database.execute(_UNITS)}
        metadata = dict(database.execute("SELECT key, value FROM metadata"))
    numbers = {*projected, *vertical, *geodetic, *(code for code, _, _ in compound)} & {*range(USER_DEFINED)}
    horizontal = projected | {code: projected[first] for code, first, _ in compound if first in projected}
    upright = vertical | {code: vertical[second] for code, _, second in compound if second in vertical}
    spans = spans_of(horizontal, numbers), spans_of(upright, numbers)
    used = sorted({*spans[0], *spans[1]})
    head = _HEAD.format(version=metadata["EPSG.VERSION"], date=metadata["EPSG.DATE"], proj=metadata["PROJ.VERSION"])
    lines = [
        "#: number of a unit → its name, and its metres",
        "UNITS: Mapping[int, tuple[str, float]] = MappingProxyType({",
        *(f'    {code}: ("{sizes[code][0]}", {sizes[code][1]!r}),' for code in used),
        "})",
        *_written("HORIZONTAL", "number of a unit → systems whose easting and northing are in it", spans[0]),
        *_written("VERTICAL", "number of a unit → systems whose heights are in it", spans[1]),
    ]
    return head + "\n" + "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.stdout.write(module_text(sys.argv[1]))
