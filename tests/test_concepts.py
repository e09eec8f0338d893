"""The checklist of concepts names each line of the sources once, and only places that exist."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGES = ROOT / "static"
LECTURE = PAGES / "src" / "pages" / "lecture"
CONCEPTS = (ROOT / "docs" / "concepts.md").read_text()
LINES = {"L": 15, "N": 10, "W": 6, "T": 9}
SECTIONS = re.findall(r'\{ id: "([\w-]+)", title: "', (LECTURE / "lessons.ts").read_text())


def rows(heading: str) -> list[list[str]]:
    """Return the cells of the table below a heading."""
    text = CONCEPTS.split(f"## {heading}\n")[1].split("\n## ")[0]
    table = [line.strip("|").split("|") for line in text.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in row] for row in table[2:]]


def test_every_line_of_the_sources_is_there_once() -> None:
    numbers = [number for number, *_ in rows("Checklist")]
    assert numbers == [f"{letter}{i}" for letter, count in LINES.items() for i in range(1, count + 1)]


def test_every_place_exists() -> None:
    assert len(SECTIONS) > 20
    for number, concept, place in rows("Checklist"):
        assert concept
        names = re.findall(r"`([^`]+)`", place)
        assert names, number
        for name in names:
            page, _, anchor = name.partition("#")
            assert (PAGES / page).is_file(), name
            assert not anchor or (page == "lecture.html" and anchor in SECTIONS), name


def test_every_section_says_what_it_teaches() -> None:
    assert [section.strip("`") for section, *_ in rows("Sections")] == SECTIONS
    assert all(teaches and state for _, teaches, state in rows("Sections"))


def test_every_section_has_a_scene_or_stays_with_the_one_before() -> None:
    scenes = (PAGES / "src" / "lessons" / "stage" / "scenes.ts").read_text()
    table = scenes.split("export const SCENES = {")[1]
    known = set(re.findall(r'^  "?([\w-]+)"?: \(\) =>', table, re.MULTILINE))
    assert set(SECTIONS) | {"start"} == known


def test_links_between_sections_lead_to_sections() -> None:
    linked = {
        name for file in LECTURE.rglob("*.tsx") for name in re.findall(r'<SectionLink to="([\w-]+)"', file.read_text())
    }
    assert len(linked) >= 5
    assert linked <= set(SECTIONS)


def test_every_marked_answer_names_its_source() -> None:
    answers = (LECTURE / "present" / "answers.ts").read_text().splitlines()
    above = [before.strip() for before, line in pairwise(answers) if line.strip().startswith("right:")]
    assert len(above) > 25
    assert [line for line in above if not line.startswith("// ")] == []


def test_the_pages_have_one_kind_of_apostrophe() -> None:
    files = [*PAGES.glob("*.html"), *(file for file in (PAGES / "src").rglob("*.ts*") if ".test." not in file.name)]
    assert len(files) > 200
    straight = re.compile(r"(?<=[A-Za-z])'(?=(?:s|t|re)\b)")
    for file in files:
        shown = re.sub(r"/\*.*?\*/|(?<!:)//[^\n]*", "", file.read_text(), flags=re.DOTALL)
        assert not straight.search(shown), file
