"""The map editor and the map in 3D: on one screen at each size, nothing for axe, targets that a finger meets."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page, expect

from tests.browser.logs.test_map_editing import written
from tests.browser.logs.test_volume import DONE
from tests.browser.looking import await_true, open_groups
from tests.browser.one_screen import SIZES, Screen
from tests.browser.pages.test_axe import nothing_wrong, told_sliders
from tests.browser.pages.test_one_screen import SCHEMES, prepare
from tests.browser.pages.test_targets import small
from tests.marks import also_long

PHONE = (390, 844)
GROUPS_AT = (SIZES[1], SIZES[3])  #: the sizes at which each group is opened: beside the map, and below it
#: What has to be in the viewport beside the picture.
DOCK = ".dock-group, .viewer-head"


def cloud(folder: Path) -> list[Path]:
    """Write the points of a floor with a step."""
    x, y = np.meshgrid(np.arange(0.05, 3.0, 0.1), np.arange(0.05, 2.0, 0.1))
    points = np.stack([x.ravel(), y.ravel(), np.where(x > 2.0, 0.3, 0.0).ravel()], axis=1)
    np.savetxt(folder / "step.xyz", points, fmt="%.2f")
    return [folder / "step.xyz"]


FILES = {
    "a map": (written, ".viewer .picture", "() => window.gridbloom?.connection.store.part('map_edits').message.peek()"),
    "a cloud": (cloud, ".viewer-map > :first-child", DONE),
}


@pytest.mark.parametrize("what", ["a map", *also_long("a cloud")])
def test_of_an_opened_file(page: Page, server: str, tmp_path: Path, what: str) -> None:
    files, picture, is_ready = FILES[what]
    prepare(page)
    page.goto(f"{server}/logs.html")
    page.set_input_files("input[type=file]", files(tmp_path))
    await_true(page, is_ready)
    screen = Screen(page, picture, DOCK)
    found: dict[str, list[object]] = {}
    for size, scheme in zip(SIZES, SCHEMES, strict=True):
        screen.resize(size, scheme)
        screen.stands("what was open")
        for title in open_groups(page) if size in GROUPS_AT else ():
            expect(page.locator(".viewer-map .working")).to_have_count(0)  # what it reports of lies on the picture
            screen.stands(title)
            if size == GROUPS_AT[0]:
                page.evaluate("() => { for (const one of document.querySelectorAll('details')) one.open = true; }")
                told_sliders(page)
                nothing_wrong(page, ".dock")
                found[title] = small(page)
    page.set_viewport_size({"width": PHONE[0], "height": PHONE[1]})
    for title in open_groups(page):
        found[f"{title}, on a phone"] = small(page)
        assert page.evaluate("() => document.documentElement.scrollWidth <= innerWidth"), title
    nothing_wrong(page)
    assert {where: targets for where, targets in found.items() if targets} == {}
