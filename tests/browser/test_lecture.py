"""The lecture in real Chromium: each figure by its handles, and what it then shows."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.conftest import SIZES
from tests.browser.looking import centre, drag, still, until

WIDER = "() => document.documentElement.scrollWidth > innerWidth + 1"


# Of each section: whether its figure is still awaited, and the height that it takes.
PLACES = """() => [...document.querySelectorAll(".lesson-figure > div")].map(
  place => [place.classList.contains("figure-awaited"), place.offsetHeight])"""


def open_section(page: Page, server: str, name: str) -> Locator:
    """Open the lecture at a section, and return the section."""
    page.goto(f"{server}/lecture.html#{name}")
    section = page.locator(f"#{name}")
    expect(section).to_be_in_viewport()
    return section


def percent(locator: Locator) -> float:
    """Return the percentage that an element shows."""
    found = re.search(r"([\d.]+) %", locator.inner_text())
    assert found
    return float(found[1])


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("context", SIZES, indirect=True)
def test_the_lecture_opens_whole(page: Page, server: str, scheme) -> None:
    page.emulate_media(color_scheme=scheme)
    page.goto(f"{server}/lecture.html")
    sections = page.locator(".lesson")
    expect(sections.first).to_be_visible()
    # Figures far from the window are not set up yet; the place that is kept for them is as high as they will be.
    expect(page.locator(".figure-awaited")).not_to_have_count(0)
    kept = page.evaluate(PLACES)
    assert sum(waits for waits, _ in kept) >= 10
    for i in range(sections.count()):
        section = sections.nth(i)
        section.scroll_into_view_if_needed()
        expect(section.locator("figure, .dropzone")).not_to_have_count(0)
        assert page.evaluate(WIDER) is False
        right = section.evaluate(
            "e => Math.max(...[...e.querySelectorAll(':not(svg *)')].map(x => x.getBoundingClientRect().right))"
        )
        assert right <= page.evaluate("innerWidth") + 1, section.get_attribute("id")
    expect(page.locator(".figure-awaited")).to_have_count(0)
    for (_, before), (_, after) in zip(kept, page.evaluate(PLACES), strict=True):
        assert after == pytest.approx(before, abs=40)


def test_the_page_does_not_jump_while_it_fills(page: Page, server: str) -> None:
    page.add_init_script(
        "window.moved = 0; new PerformanceObserver(list => {"
        " for (const shift of list.getEntries()) window.moved += shift.value;"
        "}).observe({ type: 'layout-shift', buffered: true });"
    )
    section = open_section(page, server, "sonar")
    page.wait_for_timeout(800)  # the figures around it come
    # The anchor is where it belongs, though all that is far above it is not set up, and stays there.
    at = section.evaluate("e => e.getBoundingClientRect().top - parseFloat(getComputedStyle(e).scrollMarginTop)")
    assert abs(at) < 2
    # The section in sight is marked in the list beside the lecture, and another one is a key press away.
    sections = page.get_by_role("navigation", name="Sections of the lecture")
    expect(sections.locator("[aria-current]")).to_have_text(re.compile(r"7\s+Sonar and its cone"))
    assert page.locator(".figure-awaited").count() >= 4
    page.mouse.move(700, 500)
    for way in (-700, 700):
        for _ in range(30):
            page.mouse.wheel(0, way)
            page.wait_for_timeout(30)
    expect(page.locator("#sonar .figure-awaited, #forgetting .figure-awaited, #cell .figure-awaited")).to_have_count(0)
    assert page.evaluate("window.moved") < 0.02
    sections.get_by_role("link", name="Rays on a grid").focus()
    page.keyboard.press("Enter")
    expect(sections.locator("[aria-current]")).to_have_text(re.compile("Rays on a grid"))
    expect(page.locator("#rays h2")).to_be_in_viewport()


# --- 1: independence -------------------------------------------------------------------------------------------------


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
    section.get_by_role("button", name="Begin again").click()
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


def test_the_product_runs_out_of_digits_and_the_sum_does_not(page: Page, server: str) -> None:
    section = open_section(page, server, "log-odds")
    rows = section.locator("tbody tr")
    expect(rows.nth(0)).to_contain_text("+∞")
    expect(rows.nth(1)).to_contain_text("∞")
    expect(rows.nth(2)).not_to_have_class("lost")
    cursor = section.get_by_role("slider", name="Look at the belief after reading")
    cursor.focus()
    page.keyboard.press("Home")
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    for row in range(3):  # 3 · log 9, whichever way it is kept
        expect(rows.nth(row).locator("td").last).to_have_text("6.59")


# --- 4: the model ----------------------------------------------------------------------------------------------------


def test_the_profile_feeds_the_cell(page: Page, server: str) -> None:
    section = open_section(page, server, "model")
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


def test_the_line_goes_round_and_needs_its_fixes(page: Page, server: str) -> None:
    section = open_section(page, server, "rays")
    caption = section.locator("figcaption")
    expect(caption).to_contain_text("Octant 1: a = 18, b = 7. Cell 10 of 19: ∇ = −22 < 0, so straight")
    section.get_by_role("button", name="One cell on").click()
    expect(caption).to_contain_text("Cell 11 of 19: ∇ = −8")
    end = section.get_by_role("slider", name="Where the beam ends")
    stage = section.locator(".stage").bounding_box()
    assert stage is not None
    cell = stage["width"] / 27
    drag(page, end, -15 * cell, 3 * cell)
    expect(end).to_have_attribute("aria-valuetext", "column 7, row 7")
    expect(caption).to_contain_text("Octant 2: a = 4, b = 3, axes swapped")
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
def test_a_finger_moves_the_end_of_the_beam(page: Page, server: str) -> None:
    section = open_section(page, server, "rays")
    end = section.get_by_role("slider", name="Where the beam ends")
    x, y = centre(end)
    session = page.context.new_cdp_session(page)
    for kind, dx in (("touchStart", 0), ("touchMove", -40), ("touchMove", -80), ("touchEnd", None)):
        points = [] if dx is None else [{"x": x + dx, "y": y}]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    expect(end).not_to_have_attribute("aria-valuetext", "column 22, row 10")


# --- 6: the whole algorithm ------------------------------------------------------------------------------------------


def test_the_program_runs_forwards_and_back(page: Page, server: str) -> None:
    section = open_section(page, server, "algorithm")
    lit, output = section.locator(".program-text .lit"), section.locator("output")
    expect(lit).to_have_count(1)
    expect(lit).to_contain_text("low, high = config.clamp_limits")
    start = output.inner_text()
    section.get_by_role("button", name="On").click()
    expect(lit).to_contain_text("return min(max(log_odds + evidence")
    section.get_by_role("button", name="On").click()
    expect(lit).to_contain_text("grid.observed[cell] = True")
    expect(section.locator(".program-values")).to_contain_text("→")
    for _ in range(2):
        section.get_by_role("button", name="Back").click()
    expect(output).to_have_text(start)
    section.get_by_text("a beam", exact=True).click()
    section.get_by_role("button", name="On").click()
    expect(lit).to_contain_text("evidence = evidence_of_beam")
    section.get_by_text("the scan", exact=True).click()
    section.get_by_role("button", name="On").click()
    expect(lit).to_contain_text("return updates")
    assert numbers(output)[0] == numbers(output)[1]
    section.get_by_role("button", name="To the beginning").click()
    expect(output).to_contain_text("line 1 of")
    section.get_by_text("a line", exact=True).click()
    section.get_by_role("button", name="Play").click()
    until("the program to run by itself", lambda: numbers(output)[0] > 4)
    section.get_by_role("button", name="Pause").click()


def test_the_program_is_the_textbooks_own_text(page: Page, server: str) -> None:
    section = open_section(page, server, "algorithm")
    file = (Path(__file__).parents[2] / "mapper" / "textbook.py").read_text().splitlines()
    shown = [line for line in section.locator(".program-text").inner_text().splitlines() if line.strip()]
    assert len(shown) > 40
    assert set(shown) <= set(file)


# --- 7: sonar --------------------------------------------------------------------------------------------------------


def test_the_same_echoes_wall_up_the_door_for_bayes_only(page: Page, server: str) -> None:
    section = open_section(page, server, "sonar")
    bayes, certainties = (section.locator(".side-by-side p").nth(i) for i in range(2))
    door = float(bayes.inner_text().split("p = ")[1])
    occupied = float(re.findall(r"[\d.]+", certainties.inner_text())[0])
    assert door > 0.9
    assert occupied < 0.6
    count = section.get_by_role("slider", name="Readings taken in", exact=True)
    count.focus()
    page.keyboard.press("Home")
    expect(bayes).to_contain_text("not observed")
    page.keyboard.press("End")
    expect(bayes).to_contain_text("p = ")
    section.get_by_text("weaker off the axis").click()
    assert float(bayes.inner_text().split("p = ")[1]) < door
    drag(page, section.get_by_role("slider", name="Cell to look at, Bayes"), -120, 0)
    expect(certainties).to_contain_text("occupied 0.00, empty")
    opening = section.get_by_role("slider", name="opening of the cone")
    opening.focus()
    page.keyboard.press("ArrowRight")
    expect(opening).to_have_text("31° wide")


# --- no return -------------------------------------------------------------------------------------------------------


def numbers(locator: Locator) -> list[int]:
    """Return the whole numbers in an element's text."""
    return [int(found) for found in re.findall(r"\d+", locator.inner_text())]


def test_only_the_mistake_builds_walls_where_nothing_stands(page: Page, server: str) -> None:
    section = open_section(page, server, "no-return")
    ignored, freed, mistaken = (section.locator(".side-by-side p").nth(i) for i in range(3))
    assert numbers(freed)[0] > numbers(ignored)[0] + 100
    expect(ignored).not_to_contain_text("where nothing stands")
    expect(freed).not_to_contain_text("where nothing stands")
    expect(mistaken).to_contain_text("where nothing stands")
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
    expect(section.get_by_role("slider", name="reach of the lidar")).to_have_text("9.0 m")


# --- mount -----------------------------------------------------------------------------------------------------------


def test_a_wrong_mount_smears_and_the_right_one_does_not(page: Page, server: str) -> None:
    section = open_section(page, server, "mount")
    caption = section.locator("figcaption")
    expect(caption).to_contain_text("lie where no wall is")
    section.get_by_role("button", name="right", exact=True).click()
    expect(caption).to_contain_text("all lie on walls")
    drag(page, section.get_by_role("slider", name="Sensor: which way it looks"), 0, -40)
    expect(caption).to_contain_text("lie where no wall is")
    section.get_by_role("button", name="right", exact=True).click()
    sensor = section.get_by_role("slider", name="Sensor: where it is on the robot")
    sensor.focus()
    for _ in range(6):
        page.keyboard.press("ArrowUp")
    expect(caption).to_contain_text("+0.30 m to the left")
    expect(caption).to_contain_text("lie where no wall is")
    section.get_by_role("button", name="right", exact=True).click()
    section.get_by_role("switch", name="hangs upside down").press("Space")
    expect(caption).to_contain_text("turned over")
    expect(caption).to_contain_text("lie where no wall is")


# --- forgetting ------------------------------------------------------------------------------------------------------


def test_the_table_goes_and_both_outcomes_stand_beside_the_prediction(page: Page, server: str) -> None:
    section = open_section(page, server, "forgetting")
    say = section.get_by_role("slider", name="I say: with the clamp, forgotten after")
    say.focus()
    page.keyboard.press("Home")
    for _ in range(9):
        page.keyboard.press("ArrowRight")
    section.get_by_role("button", name="Take the table away").click()
    caption = section.locator("figcaption")
    expect(caption).to_contain_text("You said 10")
    # (3.5 − log 0.65/0.35) / 0.4 is 7.2, and (40 · 0.85 − …) / 0.4 is 83.5.
    expect(caption).to_contain_text("With the clamp it was forgotten after 8")
    expect(caption).to_contain_text("without it it was forgotten after 84. You were 2 over.")
    section.get_by_role("button", name="Put it back").click()
    expect(caption).to_contain_text("How many will the map need")


def test_a_figure_off_screen_waits(page: Page, server: str) -> None:
    section = open_section(page, server, "forgetting")
    section.get_by_role("button", name="Take the table away").click()
    page.locator("#grid").scroll_into_view_if_needed()
    caption = section.locator("figcaption")

    def stands() -> bool:
        before = caption.inner_text()
        page.wait_for_timeout(600)  # of ten scans a second
        return caption.inner_text() == before

    until("the figure to stand", stands)
    expect(caption).not_to_contain_text("without it it was forgotten")  # it has not come to its end


def test_with_less_motion_the_table_goes_by_steps(page: Page, server: str) -> None:
    page.emulate_media(reduced_motion="reduce")
    section = open_section(page, server, "forgetting")
    section.get_by_role("button", name="Take the table away").click()
    caption = section.locator("figcaption")
    page.wait_for_timeout(400)
    expect(caption).to_contain_text("0 scans since it went")
    section.get_by_role("button", name="One scan on").click()
    expect(caption).to_contain_text("1 scan since it went")
    section.get_by_role("button", name="To the end").click()
    expect(caption).to_contain_text("forgotten after 84")


# --- per beam or per scan --------------------------------------------------------------------------------------------


def test_near_the_sensor_a_scan_says_it_many_times(page: Page, server: str) -> None:
    section = open_section(page, server, "counting")
    per_beam, per_scan = (section.locator(".side-by-side p").nth(i) for i in range(2))
    expect(per_beam).to_contain_text("ℓ = −2.00, p = 0.12, at the clamp")
    expect(per_scan).to_contain_text("ℓ = −0.40, p = 0.40")
    times = numbers(section.locator("figcaption b"))[0]
    beams = section.get_by_role("slider", name="Beams of a scan", exact=True)
    beams.focus()
    page.keyboard.press("End")
    assert numbers(section.locator("figcaption b"))[0] > 3 * times
    expect(per_scan).to_contain_text("ℓ = −0.40, p = 0.40")
    drag(page, section.get_by_role("slider", name="Cell to look at, map per scan"), 90, 0)
    assert numbers(section.locator("figcaption b"))[0] < 3 * times


# --- the file --------------------------------------------------------------------------------------------------------


def test_thresholds_change_the_file_and_a_reader_can_spoil_it(page: Page, server: str) -> None:
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
    reader = section.get_by_role("slider", name="free_thresh that the reader uses")
    reader.focus()
    page.keyboard.press("ArrowRight")
    expect(words).to_contain_text("All that was unknown is now free to drive on")
    page.keyboard.press("ArrowLeft")
    expect(words).not_to_contain_text("All that was unknown")


# --- your own log ----------------------------------------------------------------------------------------------------


def test_a_log_dropped_at_the_end_leads_to_the_logs_page(page: Page, server: str) -> None:
    section = open_section(page, server, "log")
    line = "FLASER 3 1.0 1.0 1.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 lecture 0.0\n"
    section.locator("input[type=file]").set_input_files(
        {"name": "lecture.log", "mimeType": "text/plain", "buffer": (line * 3).encode()}
    )
    page.wait_for_url("**/logs.html")
    expect(page.locator(".log-card", has_text="lecture.log").first).to_be_visible(timeout=30_000)


# --- presenting ------------------------------------------------------------------------------------------------------


def test_the_lecturers_mode_goes_by_keys(page: Page, server: str) -> None:
    page.goto(f"{server}/lecture.html?present#log-odds")
    count = int(page.locator(".presenter-number").inner_text().split("/")[1])
    expect(page.locator(".presenter-number")).to_have_text(f"3 / {count}")
    expect(page.locator("#log-odds figure")).to_be_in_viewport()
    expect(page.locator("#log-odds > .prose").first).to_be_hidden()
    page.keyboard.press("ArrowRight")
    expect(page.locator(".presenter-number")).to_have_text(f"4 / {count}")
    assert page.url.endswith("?present#model")
    page.keyboard.press("PageDown")
    page.keyboard.press("PageUp")
    page.keyboard.press("Space")
    expect(page.locator(".presenter-number")).to_have_text(f"5 / {count}")
    # What has the focus keeps its keys: the handle moves, the slide stays.
    end = page.get_by_role("slider", name="Where the beam ends")
    end.focus()
    page.keyboard.press("ArrowRight")
    expect(end).to_have_attribute("aria-valuetext", "column 23, row 10")
    expect(page.locator(".presenter-number")).to_have_text(f"5 / {count}")
    page.keyboard.press("Escape")
    expect(page.locator(".presenter")).to_have_count(0)
    assert page.url.endswith("/lecture.html#rays")
    expect(page.locator("#rays h2")).to_be_in_viewport()


@pytest.mark.parametrize("context", SIZES, indirect=True)
def test_every_slide_fits_its_screen(page: Page, server: str) -> None:
    if page.viewport_size and page.viewport_size["width"] > 1100:
        page.set_viewport_size({"width": 1280, "height": 720})  # an old projector
    page.goto(f"{server}/lecture.html?present#grid")
    count = int(page.locator(".presenter-number").inner_text().split("/")[1])
    for i in range(count):
        expect(page.locator(".presenter-number")).to_have_text(f"{i + 1} / {count}")
        room, figure = page.locator(".on-slide .lesson-room"), page.locator(".on-slide .lesson-figure")
        expect(figure).to_be_visible()
        expect(page.locator(".presenter")).to_be_in_viewport(ratio=1)
        still(figure)
        assert page.evaluate(WIDER) is False
        height, available = (box.evaluate("e => e.getBoundingClientRect().height") for box in (figure, room))
        if page.viewport_size and page.viewport_size["width"] > 1100:  # smaller screens may scroll within the slide
            assert height <= available + 1, page.url
        page.keyboard.press("ArrowRight")


def test_the_page_leads_into_the_lecturers_mode_and_the_front_page_here(page: Page, server: str) -> None:
    page.goto(server)
    page.get_by_role("link", name="The whole lecture").click()
    expect(page.get_by_role("heading", name="Occupancy grid mapping")).to_be_visible()
    page.get_by_role("button", name="Present").click()
    expect(page.locator(".presenter")).to_be_visible()
    page.get_by_role("button", name="Leave").click()
    expect(page.get_by_role("heading", name="Occupancy grid mapping")).to_be_attached()


def test_printed_it_shows_every_figure_in_light_colours_without_controls(page: Page, server: str) -> None:
    page.emulate_media(color_scheme="dark")
    # What there is when the printer takes its picture: figures that are set up, and canvases with light paint on them.
    page.add_init_script("""addEventListener("afterprint", () => {
      const light = canvas => {
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        return data.reduce((sum, value) => sum + value, 0) / data.length > 128;
      };
      const canvases = [...document.querySelectorAll(".stage canvas")];
      window.printed = {
        figures: document.querySelectorAll(".lesson-figure figure").length,
        canvases: canvases.length,
        light: canvases.filter(light).length,
      };
    })""")
    page.goto(f"{server}/lecture.html")
    expect(page.locator("#grid figure")).to_be_visible()
    page.pdf()
    printed = page.evaluate("printed")
    assert printed["figures"] == page.locator(".lesson").count()
    assert printed["light"] == printed["canvases"] >= 14
    expect(page.locator("html")).not_to_have_attribute("data-theme", "light")
    page.emulate_media(media="print")
    expect(page.locator(".section-list")).to_be_hidden()
    expect(page.locator("#rays .stage")).to_be_visible()
    expect(page.locator("#rays .rays-controls")).to_be_hidden()
    expect(page.locator("#cell .cell-buttons")).to_be_hidden()
