"""The pages' fonts hold every character that the pages write, are small, and keep to their licence."""

from __future__ import annotations

import unicodedata
from pathlib import Path

import pytest
from fontTools.ttLib import TTFont

ROOT = Path(__file__).parents[1]
ASSETS = ROOT / "static" / "dist" / "assets"
#: the fonts that a family's text is taken from, as tokens.css lists them
FAMILIES = {
    "ui": ("sans", "math"),
    "prose": ("serif", "serif-greek", "sans", "math"),
    "mono": ("mono", "sans", "math"),
}


@pytest.fixture(scope="module")
def fonts() -> dict[str, Path]:
    return {path.stem[:-9]: path for path in ASSETS.glob("*.woff2")}  # Vite appends "-" and a hash of 8


def written() -> set[str]:
    """Return the characters of the pages' sources, and of the parameters' sentences that they show."""
    sources = [path for path in (ROOT / "static" / "src").rglob("*.ts*") if ".test." not in path.name]
    sources += [ROOT / "mapper" / "mapping" / "parameters.py", *(ROOT / "mapper" / "diagnosis").glob("*.py")]
    # a comment is not shown, and a combining sign is part of the letter before it
    lines = [line for path in sources for line in path.read_text().splitlines()]
    shown = [line.split("//")[0] for line in lines if not line.lstrip().startswith(("*", "/*", "//", "#"))]
    return {c for line in shown for c in line if ord(c) > 0x7E and unicodedata.category(c)[0] != "M"}


def test_every_character_of_the_pages_is_in_their_fonts(fonts: dict[str, Path]) -> None:
    characters = written()
    assert {"ℓ", "−", "→", "θ"} <= characters
    held = {name: {chr(code) for code in TTFont(path).getBestCmap()} for name, path in fonts.items()}
    for family, names in FAMILIES.items():
        assert characters - set().union(*(held[name] for name in names)) == set(), family


def test_the_fonts_are_small(fonts: dict[str, Path]) -> None:
    sizes = {name: path.stat().st_size for name, path in fonts.items()}
    assert sum(sizes.values()) < 125_000, sizes
    assert sizes["sans"] + sizes["serif"] < 70_000, sizes  # what every page loads before its first text


def test_the_fonts_bear_no_reserved_name_and_their_licences_are_beside_them(fonts: dict[str, Path]) -> None:
    licences = (ASSETS / "font-licences.txt").read_text()
    assert licences.count("SIL OPEN FONT LICENSE Version 1.1") == 4
    for path in fonts.values():
        names = TTFont(path)["name"]
        assert all("Source" not in names.getDebugName(name) for name in (1, 4, 6)), path.name
        assert names.getDebugName(0), path.name  # the copyright notice
    math = TTFont(fonts["math"])
    assert math["MATH"].table.MathVariants.MinConnectorOverlap > 0  # braces stretch


def test_digits_have_one_width_where_columns_of_numbers_need_it(fonts: dict[str, Path]) -> None:
    for name in ("sans", "mono"):
        font = TTFont(fonts[name])
        assert len({font["hmtx"][font.getBestCmap()[ord(digit)]][0] for digit in "0123456789"}) == 1, name
