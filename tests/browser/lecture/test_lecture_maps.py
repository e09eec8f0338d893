"""The lecture's figures of whole maps in Chromium, by their handles."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page, expect

from tests.browser.lecturing import numbers, open_section
from tests.browser.looking import drag, frames, until

# --- no return -------------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_only_the_mistake_maps_walls_in_free_space(page: Page, server: str) -> None:
    section = open_section(page, server, "no-return")
    ignored, freed, mistaken = (section.locator(".side-by-side p").nth(i) for i in range(3))
    assert numbers(freed)[0] > numbers(ignored)[0] + 100
    expect(ignored).not_to_contain_text("where no wall is")
    expect(freed).not_to_contain_text("where no wall is")
    expect(mistaken).to_contain_text("where no wall is")
    before = numbers(ignored)
    robot = section.get_by_role("slider", name="Robot, map with no returns ignored")
    drag(page, robot, 60, -20)
    until("another map", lambda: numbers(ignored) != before)
    text = robot.get_attribute("aria-valuetext")
    page.keyboard.press("ArrowRight")
    expect(robot).not_to_have_attribute("aria-valuetext", text or "")
    reach = section.get_by_role("slider", name="Max range of the lidar")
    reach.focus()
    page.keyboard.press("End")
    expect(section.get_by_role("slider", name="max range, lidar")).to_have_text("9.0 m")


# --- mount -----------------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_a_wrong_mount_smears_and_the_right_one_does_not(page: Page, server: str) -> None:
    section = open_section(page, server, "mount")
    caption = section.locator("figcaption")
    expect(caption).to_contain_text("lie where no wall is")
    section.get_by_role("button", name="correct", exact=True).click()
    expect(caption).to_contain_text("all lie on walls")
    drag(page, section.get_by_role("slider", name="Direction of the sensor"), 0, -40)
    expect(caption).to_contain_text("lie where no wall is")
    section.get_by_role("button", name="correct", exact=True).click()
    sensor = section.get_by_role("slider", name="Position of the sensor")
    sensor.focus()
    for _ in range(6):
        page.keyboard.press("ArrowUp")
    expect(caption).to_contain_text("+0.30 m to the left")
    expect(caption).to_contain_text("lie where no wall is")
    section.get_by_role("button", name="correct", exact=True).click()
    section.get_by_role("switch", name="mounted upside down").press("Space")
    expect(caption).to_contain_text("upside down")
    expect(caption).to_contain_text("lie where no wall is")


# --- forgetting ------------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_both_outcomes_are_shown_with_the_prediction_after_the_table_is_removed(page: Page, server: str) -> None:
    section = open_section(page, server, "forgetting")
    say = section.get_by_role("slider", name="My guess")
    say.focus()
    page.keyboard.press("Home")
    for _ in range(9):
        page.keyboard.press("ArrowRight")
    section.get_by_role("button", name="Remove the table").click()
    caption = section.locator("figcaption")
    expect(caption).to_contain_text("Your guess: 10")
    section.get_by_role("button", name="To the end").click()
    # (3.5 − log 0.25/0.75) / 0.4 is 11.5, and (40 · 0.85 − …) / 0.4 is 87.7.
    expect(caption).to_contain_text("With the clamp: forgotten after 12")
    expect(caption).to_contain_text("without it: forgotten after 88. Your guess was 2 too low.")
    section.get_by_role("button", name="Put the table back").click()
    expect(caption).to_contain_text("How many scans does the map need")


@pytest.mark.moving
def test_a_figure_off_screen_is_paused(page: Page, server: str) -> None:
    section = open_section(page, server, "forgetting")
    section.get_by_role("button", name="Remove the table").click()
    page.locator("#grid").scroll_into_view_if_needed()
    caption = section.locator("figcaption")

    def stands() -> bool:
        before = caption.inner_text()
        frames(page, 36)  # of which there are six for each scan
        return caption.inner_text() == before

    until("the figure to stand", stands)
    expect(caption).not_to_contain_text("without it: forgotten")  # it has not come to its end


def test_with_reduced_motion_the_table_is_removed_in_steps(page: Page, server: str) -> None:
    page.emulate_media(reduced_motion="reduce")
    section = open_section(page, server, "forgetting")
    section.get_by_role("button", name="Remove the table").click()
    caption = section.locator("figcaption")
    frames(page, 24)
    expect(caption).to_contain_text("0 scans since it was removed")
    section.get_by_role("button", name="Forward one scan").click()
    expect(caption).to_contain_text("1 scan since it was removed")
    section.get_by_role("button", name="To the end").click()
    expect(caption).to_contain_text("forgotten after 88")


# --- per beam or per scan --------------------------------------------------------------------------------------------


@pytest.mark.long
def test_near_the_sensor_a_scan_updates_cells_many_times(page: Page, server: str) -> None:
    section = open_section(page, server, "counting")
    per_beam, per_scan = (section.locator(".side-by-side p").nth(i) for i in range(2))
    expect(per_beam).to_contain_text("ℓ = −2.00, p = 0.12, at the clamp")
    expect(per_scan).to_contain_text("ℓ = −0.40, p = 0.40")
    times = numbers(section.locator("figcaption b"))[0]
    beams = section.get_by_role("slider", name="Beams per scan", exact=True)
    beams.focus()
    page.keyboard.press("End")
    assert numbers(section.locator("figcaption b"))[0] > 3 * times
    expect(per_scan).to_contain_text("ℓ = −0.40, p = 0.40")
    drag(page, section.get_by_role("slider", name="Selected cell, map per scan"), 90, 0)
    assert numbers(section.locator("figcaption b"))[0] < 3 * times


# --- the file --------------------------------------------------------------------------------------------------------


def test_thresholds_change_the_file_and_its_reading(page: Page, server: str) -> None:
    section = open_section(page, server, "file")
    words = section.locator("figure > p")
    free, unknown, occupied, *read = numbers(words)
    assert [free, unknown, occupied] == read
    expect(section.locator("pre").first).to_contain_text("occupied_thresh: 0.65\nfree_thresh: 0.196")
    drag(page, section.get_by_role("slider", name="Occupied above"), 120, 0)
    assert numbers(words)[2] < occupied
    handle = section.get_by_role("slider", name="Free below")
    handle.focus()
    for _ in range(8):
        page.keyboard.press("ArrowLeft")
    expect(handle).to_have_attribute("aria-valuenow", "0.17")
    assert numbers(words)[0] < free
    reader = section.get_by_role("slider", name="free_thresh of the reader")
    reader.focus()
    page.keyboard.press("ArrowRight")
    expect(words).to_contain_text("All unknown cells are read as free")
    page.keyboard.press("ArrowLeft")
    expect(words).not_to_contain_text("All unknown cells")
