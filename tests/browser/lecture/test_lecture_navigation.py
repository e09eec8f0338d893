"""The lecture's sections on what is built on the map, in Chromium: each figure by its handles."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.lecturing import open_section
from tests.browser.looking import drag

NUMBER = re.compile(r"\d[\d,]*\.?\d*")


def first_number(locator: Locator, after: str) -> float:
    """Return the first number behind some words."""
    found = NUMBER.search(locator.inner_text().split(after, 1)[1])
    assert found
    return float(found[0].replace(",", ""))


def test_the_sections_on_what_is_built_on_the_map(page: Page, server: str) -> None:
    section = open_section(page, server, "particles")
    stage = page.get_by_role("complementary", name="Stage")
    caption = stage.locator(".world-stage-caption p").first
    figcaption = section.locator(".particles figcaption")
    expect(figcaption).to_contain_text("“door”")
    # A robot at a wall is weighed by another reading, and the comb keeps all particles of equal weight.
    drag(page, section.get_by_role("slider", name="Robot in the corridor"), 25, 0)
    expect(figcaption).to_contain_text("“wall”")
    section.get_by_role("button", name="From the start").click()
    # KLD sampling counts the bins of these particles: fewer after the draw, and so are the particles that are wanted.
    number = section.get_by_role("figure", name="Number of particles by the number of occupied bins")
    expect(number.locator("figcaption")).to_contain_text("24 of 24 bins: M = 417 for ε = 0.05")
    section.get_by_role("button", name="Resample").click()
    expect(number.locator("figcaption")).not_to_contain_text("24 of 24 bins")
    few = first_number(number.locator("figcaption"), "M =")
    drag(page, number.get_by_role("slider", name="ε"), 0, -60)
    assert first_number(number.locator("figcaption"), "M =") > few
    number.get_by_role("slider", name="q", exact=True).press("ArrowUp")
    expect(number.locator("figcaption")).to_contain_text("q = 2.43")
    expect(figcaption).to_contain_text("all particles count the same")
    expect(section.get_by_text("resampled: 24 of 24 are left")).to_be_visible()
    section.get_by_text("independent", exact=True).click()
    expect(section.get_by_text("resampled: 24 of 24 are left")).to_have_count(0)

    section = open_section(page, server, "sensor-models")
    figcaption = section.locator("figcaption")
    expect(caption).to_contain_text("likelihood field")
    before = figcaption.inner_text()
    hit = section.get_by_role("slider", name="hit", exact=True)
    drag(page, hit, 0, 40)
    assert float(hit.get_attribute("aria-valuenow") or 1) < 0.6
    assert figcaption.inner_text() != before
    shares = [
        float(section.get_by_role("slider", name=name, exact=True).get_attribute("aria-valuenow") or 0)
        for name in ("hit", "short", "max range", "random")
    ]
    assert abs(sum(shares) - 1) < 0.002
    assumed = stage.get_by_role("slider", name="Assumed pose of the scan")
    off = first_number(caption, "Here log p(z | x, m) = −")
    assumed.focus()
    for _ in range(5):
        page.keyboard.press("ArrowLeft")
    for _ in range(3):
        page.keyboard.press("ArrowDown")
    assert first_number(caption, "Here log p(z | x, m) = −") < off

    section = open_section(page, server, "kidnapping")
    expect(caption).to_contain_text("carried away 4 scans ago. 0 %")
    one_scan = section.get_by_role("button", name="One scan")
    for _ in range(25):
        one_scan.click()
    expect(caption).to_contain_text(re.compile(r"29 scans ago. (9\d|100) %"))
    drag(page, stage.get_by_role("slider", name="Robot"), 90, 60)
    expect(caption).to_contain_text("carried away just now")

    section = open_section(page, server, "layers")
    expect(caption).to_contain_text(re.compile("Under the cross: cost [1-9]"))
    section.get_by_role("switch", name=re.compile("^inflation")).press("Space")
    expect(caption).to_contain_text("Under the cross: free, 0")
    page.get_by_role("button", name="Back to the lecture’s path").click()
    expect(caption).to_contain_text(re.compile("Under the cross: cost [1-9]"))

    section = open_section(page, server, "inflation")
    expect(caption).to_contain_text("In the middle of the right door")
    door = first_number(caption, "right door:")
    drag(page, section.get_by_role("slider", name="Cost scaling factor"), 0, 40)
    assert first_number(caption, "right door:") < door

    section = open_section(page, server, "path")
    expect(caption).to_contain_text("The path is")
    length = first_number(caption, "The path is")
    drag(page, stage.get_by_role("slider", name="Goal"), -150, 40)
    assert first_number(caption, "The path is") < length
    dijkstra, a_star = (
        first_number(section.locator("tbody tr").nth(i), word) for i, word in ((0, "Dijkstra"), (1, "A*"))
    )
    assert a_star < dijkstra
    section.get_by_role("slider", name="Inscribed radius", exact=True).press("End")
    expect(caption).to_contain_text("No path")
    page.get_by_role("button", name="Back to the lecture’s path").click()

    section = open_section(page, server, "lifetime")
    expect(caption).to_contain_text(re.compile(r"the path is [1-9]\.\d\d m longer"))
    section.get_by_text("lifetime", exact=True).last.click()
    expect(caption).to_contain_text("Forgotten in 9 s")
    section.get_by_role("slider", name="Time since its removal", exact=True).press("End")
    expect(caption).to_contain_text("None of its cells is left, and the path is 0.00 m longer")

    section = open_section(page, server, "stack")
    expect(section.locator("[aria-current=step]")).to_contain_text("Nav2")
    expect(caption).to_contain_text("Nav2: a path of")
    length = first_number(caption, "a path of")
    drag(page, stage.get_by_role("slider", name="Goal"), 0, 60)
    assert first_number(caption, "a path of") < length
    section.get_by_role("button", name="AMCL").click()
    expect(caption).to_contain_text("After 0 scans 0 %")
    section.get_by_role("slider", name="Step", exact=True).press("Home")
    expect(caption).to_contain_text("2 of 77 scans")

    section = open_section(page, server, "octree")
    expect(caption).to_contain_text("The low table is not in this plane")
    section.get_by_role("slider", name="Cut height", exact=True).press("Home")
    expect(caption).to_contain_text("The low table is cut")
    dense, tree, points = (section.locator("tbody tr").nth(i).locator("td").last for i in range(3))
    at_10_cm = [one.inner_text() for one in (dense, tree, points)]
    section.get_by_text("40", exact=True).click()
    at_40_cm = [one.inner_text() for one in (dense, tree, points)]
    assert at_10_cm[2] == at_40_cm[2]
    assert at_10_cm[:2] != at_40_cm[:2]

    section = open_section(page, server, "tsdf")
    cells, distance = (section.locator("tbody tr").first.locator("td").nth(i) for i in (0, 1))
    expect(cells).to_have_text("in the cell 1.2 … 1.3 m")
    at = [first_number(distance, "at")]
    wall = section.get_by_role("slider", name="Wall", exact=True)
    wall.press("ArrowRight")
    expect(wall).to_have_attribute("aria-valuetext", "1.24 m from the sensor")
    at.append(first_number(distance, "at"))
    assert abs(at[1] - at[0] - 0.01) < 0.0015
    expect(cells).to_have_text("in the cell 1.2 … 1.3 m")
    drag(page, section.get_by_role("slider", name="Truncation", exact=True), -40, 0)
    expect(section.locator("tbody tr").nth(2).locator("td").last).to_have_text("nothing stored")
    section.get_by_role("switch", name="Store free space too").press("Space")
    expect(section.locator("tbody tr").nth(2).locator("td").last).to_contain_text("D = +0.")


@pytest.mark.parametrize("context", ["phone"], indirect=True)
def test_a_label_of_the_beam_model_keeps_off_the_bar_of_the_max_range(page: Page, server: str) -> None:
    section = open_section(page, server, "sensor-models")
    label = section.locator(".forward-name.rand").bounding_box()
    bar = section.locator(".forward-max").bounding_box()
    assert label is not None
    assert bar is not None
    assert label["x"] + label["width"] + 4 <= bar["x"]
