"""The spans of EPSG's numbers by unit: as a database has them, and as the dataset itself says of some."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from mapper.io.clouds.projection import units_of
from mapper.tools.epsg_units import module_text
from tests.reports.test_clouds import keys

TABLES = """
CREATE TABLE axis (coordinate_system_auth_name, coordinate_system_code, coordinate_system_order INT, uom_code);
CREATE TABLE projected_crs (auth_name, code, coordinate_system_auth_name, coordinate_system_code);
CREATE TABLE vertical_crs (auth_name, code, coordinate_system_auth_name, coordinate_system_code);
CREATE TABLE geodetic_crs (auth_name, code, coordinate_system_auth_name, coordinate_system_code);
CREATE TABLE compound_crs
    (auth_name, code, horiz_crs_auth_name, horiz_crs_code, vertical_crs_auth_name, vertical_crs_code);
CREATE TABLE unit_of_measure (auth_name, code, name, type, conv_factor);
CREATE TABLE metadata (key, value);
INSERT INTO axis VALUES ('EPSG', '1', 1, '9001'), ('EPSG', '1', 2, '9001'), ('EPSG', '2', 1, '9002'),
    ('EPSG', '3', 1, '9122');
INSERT INTO unit_of_measure VALUES ('EPSG', '9001', 'metre', 'length', 1.0), ('EPSG', '9002', 'foot', 'length', 0.3048),
    ('EPSG', '9122', 'degree', 'angle', 0.0174);
INSERT INTO metadata VALUES ('EPSG.VERSION', 'v1'), ('EPSG.DATE', '2020-02-02'), ('PROJ.VERSION', '9');
"""


def test_numbers_are_joined_unless_another_system_lies_between(tmp_path: Path) -> None:
    with closing(sqlite3.connect(tmp_path / "proj.db")) as database:
        database.executescript(TABLES)
        for table, code, system in (
            ("projected", 2000, 1), ("projected", 2005, 1), ("geodetic", 2006, 3), ("projected", 2007, 1),
            ("projected", 2008, 2), ("projected", 2010, 1), ("projected", 40000, 1), ("vertical", 5000, 2),
        ):  # fmt: skip
            database.execute(f"INSERT INTO {table}_crs VALUES ('EPSG', '{code}', 'EPSG', '{system}')")
        database.execute("INSERT INTO compound_crs VALUES ('EPSG', '6000', 'EPSG', '2010', 'EPSG', '5000')")
        database.commit()
    found: dict[str, dict[int, object]] = {}
    exec(module_text(str(tmp_path / "proj.db")), found)
    assert found["UNITS"] == {9001: ("metre", 1.0), 9002: ("foot", 0.3048)}
    assert found["HORIZONTAL"] == {9001: "2000-2005 2007 2010 6000", 9002: "2008"}
    assert found["VERTICAL"] == {9002: "5000-6000"}


#: numbers of systems, and the metres of the units of x and y, and of z, by epsg.org
KNOWN = {
    32633: (1.0, None), 27700: (1.0, None), 2193: (1.0, None), 2263: (1200 / 3937, None), 2992: (0.3048, None),
    6597: (1200 / 3937, None), 3857: (1.0, None), 5556: (1.0, 1.0), 8734: (0.3048006096, 0.3048006096),
}  # fmt: skip


@pytest.mark.parametrize("number", KNOWN)
def test_units_of_systems(number: int) -> None:
    found = units_of({34735: keys((1024, 1), (3072, number))})
    assert found is not None
    assert found.unstated is None
    size, height = KNOWN[number]
    assert found.horizontal[1] == pytest.approx(size)
    assert (None if found.vertical is None else found.vertical[1]) == (
        None if height is None else pytest.approx(height)
    )
