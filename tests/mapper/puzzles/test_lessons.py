"""Each puzzle teaches a sentence that its section of the lecture has."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from mapper.puzzles import CAUSES

PAGES = Path(__file__).parents[3] / "static" / "src" / "pages"


def words(text: str) -> str:
    """Return a text as a reader sees it: without markup, in one line."""
    bare = re.sub(r"</?\w[^<>]*>", "", text.replace('{" "}', " "))
    return re.sub(r"\s+", " ", bare)


def section_text(section: str) -> str:
    """Return the text of a section: of the function that the lecture renders for its id."""
    page = (PAGES / "lecture.tsx").read_text(encoding="utf-8")
    bodies = page[page.index("const BODIES") :]
    name = re.search(rf'[\s{{]"?{re.escape(section)}"?: (\w+),', bodies)
    assert name, f"the lecture has no section {section}"
    file = re.search(rf'import {{[^}}]*\b{name[1]}\b[^}}]*}} from "(\./[^"]+)"', page)
    assert file, name[1]
    source = (PAGES / f"{file[1]}.tsx").read_text(encoding="utf-8")
    body = source[source.index(f"export function {name[1]}") :]
    after = body.find("\nexport function ", 1)
    return words(body if after < 0 else body[:after])


@pytest.mark.parametrize("name", CAUSES)
def test_the_section_of_a_cause_has_its_sentence(name: str) -> None:
    cause = CAUSES[name]
    assert cause.lesson.endswith(".")
    assert cause.lesson.removesuffix(".") in section_text(cause.section)


def test_each_cause_teaches_a_sentence_of_its_own() -> None:
    assert len({cause.lesson for cause in CAUSES.values()}) == len(CAUSES)
