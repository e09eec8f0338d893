"""The lecture's figures of a cell, a beam and a scan in Chromium, by their handles."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.lecturing import numbers, open_section
from tests.browser.looking import centre, drag, until


def percent(locator: Locator) -> float:
    """Return the percentage that an element shows."""
    found = re.search(r"([\d.]+) %", locator.inner_text())
    assert found
    return float(found[1])


# --- 1: independence -------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_only_the_joint_shifts_the_blame(page: Page, server: str) -> None:
    section = open_section(page, server, "grid")
    joint, grid = section.locator("figcaption .joint-number"), section.locator("figcaption .grid-number")
    assert percent(joint) < 10
    assert percent(grid) > 40
    fifth = section.get_by_role("button", name=re.compile(r"^Cell 5"))
    third = section.get_by_role("button", name=re.compile(r"^Cell 3"))
    before = percent_in(third, "joint"), percent_in(third, "Grid map")
    fifth.focus()
    page.keyboard.press("Enter")  # now the beam passed it as well: one suspect is left
    expect(fifth).to_have_accessible_name(re.compile("beam passed"))
    assert percent_in(third, "joint") > before[0] + 15
    assert percent_in(third, "Grid map") == before[1]


def percent_in(button: Locator, which: str) -> float:
    """Return the percentage that a cell's name states after a word."""
    found = re.search(rf"{which} ([\d.]+) %", button.get_attribute("aria-label") or "")
    assert found
    return float(found[1])


def test_a_number_in_the_prose_can_be_dragged(page: Page, server: str) -> None:
    section = open_section(page, server, "grid")
    prior = section.get_by_role("slider", name="prior of a cell")
    before = percent(section.locator("figcaption .grid-number"))
    drag(page, prior, 60, 0)
    expect(prior).to_have_text("30 %")
    assert percent(section.locator("figcaption .grid-number")) < before
    page.keyboard.press("Home")
    expect(prior).to_have_attribute("aria-valuenow", "5")


# --- 2: one cell -----------------------------------------------------------------------------------------------------


def test_the_cell_is_fed_by_buttons_and_keys(page: Page, server: str) -> None:
    section = open_section(page, server, "cell")
    caption = section.locator("figcaption")
    section.get_by_role("button", name="Reset the cell").click()
    expect(caption).to_contain_text("ℓ = 0.00 · odds 1.00 : 1")
    section.get_by_role("button", name="hit +0.85").click()
    expect(caption).to_contain_text("ℓ = 0.85 · odds 2.34 : 1")
    page.keyboard.press("m")
    expect(caption).to_contain_text("ℓ = 0.45")
    expect(section.locator(".prose").last).to_contain_text("0.85 − 0.40 = 0.45, which is p = 0.61")
    for _ in range(8):
        page.keyboard.press("h")
    expect(caption).to_contain_text("ℓ = 3.50")
    expect(section.locator(".prose").last).to_contain_text("clamped to 3.50")


# --- 3: digits -------------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_the_product_runs_out_of_digits_and_the_sum_does_not(page: Page, server: str) -> None:
    section = open_section(page, server, "log-odds")
    rows = section.locator("tbody tr")
    expect(rows.nth(0)).to_contain_text("+∞")
    expect(rows.nth(1)).to_contain_text("∞")
    expect(rows.nth(2)).not_to_have_class("lost")
    cursor = section.get_by_role("slider", name="Show the belief after reading")
    cursor.focus()
    page.keyboard.press("Home")
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    for row in range(3):  # 3 · log 9, whichever way it is kept
        expect(rows.nth(row).locator("td").last).to_have_text("6.59")


# --- 4: the model ----------------------------------------------------------------------------------------------------


def test_the_profile_feeds_the_cell(page: Page, server: str) -> None:
    section = open_section(page, server, "model")
    section.get_by_label("Model", exact=True).select_option("fixed_increments")
    handle = section.get_by_role("slider", name="Hit increment")
    handle.focus()
    page.keyboard.press("ArrowUp")
    expect(handle).to_have_attribute("aria-valuenow", "0.9")
    page.locator("#cell").scroll_into_view_if_needed()
    expect(page.locator("#cell").get_by_role("button", name="hit +0.90")).to_be_attached()
    for model in ("step_window", "smooth_ramp", "sonar_cone", "moravec_elfes", "hit_counting"):
        section.get_by_label("Model", exact=True).select_option(model)
        expect(section.locator("figure svg")).to_be_visible()
        expect(page.locator("#cell").get_by_role("button", name="hit +0.90")).to_be_attached()


# --- 5: rays ---------------------------------------------------------------------------------------------------------


def test_the_line_algorithm_needs_its_corrections_in_all_octants(page: Page, server: str) -> None:
    section = open_section(page, server, "rays")
    caption = section.locator("figcaption")
    expect(caption).to_contain_text("Octant 1: dx = 18, dy = 7. Cell 10 of 19: ∇ = −22 < 0, so straight")
    section.get_by_role("button", name="Forward one cell").click()
    expect(caption).to_contain_text("Cell 11 of 19: ∇ = −8")
    end = section.get_by_role("slider", name="Last cell of the line")
    stage = section.locator(".stage").bounding_box()
    assert stage is not None
    cell = stage["width"] / 27
    drag(page, end, -15 * cell, 3 * cell)
    expect(end).to_have_attribute("aria-valuetext", "column 7, row 7")
    expect(caption).to_contain_text("Octant 2: dx = 4, dy = 3, axes swapped")
    section.get_by_role("switch", name="fix 2").press("Space")
    expect(caption).to_contain_text("a fix is missing")
    section.get_by_role("switch", name="fix 2").press("Space")
    expect(caption).not_to_contain_text("a fix is missing")
    end.focus()
    for _ in range(5):
        page.keyboard.press("ArrowLeft")
    expect(end).to_have_attribute("aria-valuetext", "column 2, row 7")
    expect(caption).to_contain_text("Octant 3")
    section.get_by_role("switch", name="exact traversal").press("Space")
    expect(caption).to_contain_text("The beam itself crosses")


@pytest.mark.parametrize("context", ["phone"], indirect=True)
@pytest.mark.long
def test_a_finger_moves_the_end_of_the_beam(page: Page, server: str) -> None:
    section = open_section(page, server, "rays")
    end = section.get_by_role("slider", name="Last cell of the line")
    x, y = centre(end)
    session = page.context.new_cdp_session(page)
    for kind, dx in (("touchStart", 0), ("touchMove", -40), ("touchMove", -80), ("touchEnd", None)):
        points = [] if dx is None else [{"x": x + dx, "y": y}]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    expect(end).not_to_have_attribute("aria-valuetext", "column 22, row 10")


# --- 6: the whole algorithm ------------------------------------------------------------------------------------------


@pytest.mark.moving
def test_the_program_runs_forwards_and_back(page: Page, server: str) -> None:
    section = open_section(page, server, "algorithm")
    section.get_by_text("beam by beam", exact=True).click()
    section = section.locator(".program")
    lit, output = section.locator(".program-text .lit"), section.locator("output")
    expect(lit).to_have_count(1)
    expect(lit).to_contain_text("low, high = config.clamp_limits")
    start = output.inner_text()
    section.get_by_role("button", name="Step forward").click()
    expect(lit).to_contain_text("return min(max(log_odds + evidence")
    section.get_by_role("button", name="Step forward").click()
    expect(lit).to_contain_text("grid.observed[cell] = True")
    expect(section.locator(".program-values")).to_contain_text("→")
    for _ in range(2):
        section.get_by_role("button", name="Step back").click()
    expect(output).to_have_text(start)
    section.locator(".choice-option", has_text="beam").click()
    section.get_by_role("button", name="Step forward").click()
    expect(lit).to_contain_text("evidence = evidence_of_beam")
    section.locator(".choice-option", has_text="scan").click()
    section.get_by_role("button", name="Step forward").click()
    expect(lit).to_contain_text("return updates")
    assert numbers(output)[0] == numbers(output)[1]
    section.get_by_role("button", name="Back to the start").click()
    expect(output).to_contain_text("line 1 of")
    section.locator(".choice-option", has_text="line").click()
    section.get_by_role("button", name="Play").click()
    until("the program to run by itself", lambda: numbers(output)[0] > 4)
    section.get_by_role("button", name="Pause").click()


def test_the_program_is_the_textbooks_own_text(page: Page, server: str) -> None:
    section = open_section(page, server, "algorithm")
    section.get_by_text("beam by beam", exact=True).click()
    file = (Path(__file__).parents[3] / "mapper" / "mapping" / "textbook.py").read_text().splitlines()
    shown = [line for line in section.locator(".program-text").inner_text().splitlines() if line.strip()]
    assert len(shown) > 40
    assert set(shown) <= set(file)


# --- 7: sonar --------------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_the_same_echoes_wall_up_the_door_for_bayes_only(page: Page, server: str) -> None:
    section = open_section(page, server, "sonar")
    bayes, certainties = (section.locator(".side-by-side p").nth(i) for i in range(2))
    door = float(bayes.inner_text().split("p = ")[1])
    occupied = float(re.findall(r"[\d.]+", certainties.inner_text())[0])
    assert door > 0.9
    assert occupied < 0.6
    count = section.get_by_role("slider", name="Number of readings", exact=True)
    count.focus()
    page.keyboard.press("Home")
    expect(bayes).to_contain_text("not observed")
    page.keyboard.press("End")
    expect(bayes).to_contain_text("p = ")
    section.get_by_text("weaker away from the axis").click()
    assert float(bayes.inner_text().split("p = ")[1]) < door
    drag(page, section.get_by_role("slider", name="Selected cell, Bayes"), -120, 0)
    expect(certainties).to_contain_text("occupied 0.00, empty")
    opening = section.get_by_role("slider", name="opening of the cone")
    opening.focus()
    page.keyboard.press("ArrowRight")
    expect(opening).to_have_text("31° wide")
