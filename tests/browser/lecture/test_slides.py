"""The lecture as slides: keys, steps, deep links, the speaker's window, decks, and the size of what is on them."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from playwright.sync_api import Locator, Page, Route, expect

from tests.browser.looking import drag_along, still, until
from tests.browser.pages.test_axe import nothing_wrong, violations
from tests.browser.pages.test_targets import small
from tests.browser.slides import cut_off, settle, slide_ids, small_texts

LABEL_PX = 22  #: least size of text on a screen of 1920 x 1080


def number(page: Page) -> int:
    """Return the number of the slide."""
    return int(page.locator(".presenter-number").inner_text().split("/")[0])


def at(page: Page, end: str) -> None:
    """Wait until the address ends so: Playwright hears of it a moment after the key was pressed."""
    expect(page).to_have_url(re.compile(re.escape(end) + "$"))


def present(page: Page, server: str, fragment: str = "") -> None:
    """Open the presentation again."""
    page.goto("about:blank")
    page.goto(f"{server}/lecture.html?present{fragment}")
    expect(page.locator(".presenter-number")).to_be_visible()


# --- keys and steps --------------------------------------------------------------------------------------------------


def test_a_slide_asks_then_lets_predict_then_shows_then_answers(page: Page, server: str) -> None:
    present(page, server, "#sonar")
    question = page.locator(".slide-question-text")
    expect(question).to_contain_text("open door")
    expect(page.locator("#sonar figure")).to_be_hidden()
    page.keyboard.press("PageDown")
    page.get_by_role("button", name="An opening").click()
    expect(page.get_by_role("button", name="An opening")).to_have_attribute("aria-pressed", "true")
    page.keyboard.press("Space")  # the option was clicked, and does not keep the key
    expect(page.locator("#sonar figure")).to_be_visible()
    expect(page.get_by_role("heading", name="open door")).to_be_visible()
    expect(page.locator(".presenter-answer")).to_have_text("")
    page.keyboard.press("ArrowRight")
    expect(page.locator(".presenter-answer")).to_contain_text("× A is wrong, B is right. A wall")
    at(page, "?present#sonar/4")
    before = number(page)
    page.keyboard.press("ArrowRight")
    at(page, "?present#mount")
    assert number(page) == before + 1
    page.keyboard.press("PageUp")
    expect(page.locator(".presenter-answer")).to_contain_text("A is wrong")


def test_pages_turn_whatever_has_the_focus(page: Page, server: str) -> None:
    present(page, server, "#log-odds/3")
    slider = page.get_by_role("slider", name="Show the belief after reading")
    box = slider.bounding_box()
    assert box
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    expect(slider).to_be_focused()
    chosen = slider.get_attribute("aria-valuetext")
    page.keyboard.press("PageDown")
    at(page, "#log-odds/4")
    page.keyboard.press("ArrowLeft")
    at(page, "#log-odds/3")
    assert slider.get_attribute("aria-valuetext") == chosen
    # With Tab the slider takes the arrows, and the slide says so; the clicker's keys still turn the page.
    page.keyboard.press("Shift+Tab")
    page.keyboard.press("Tab")
    expect(slider).to_be_focused()
    expect(page.locator(".presenter-arrows")).to_contain_text("Show the belief after reading")
    page.keyboard.press("ArrowLeft")
    assert slider.get_attribute("aria-valuetext") != chosen
    at(page, "#log-odds/3")
    page.keyboard.press("PageDown")
    at(page, "#log-odds/4")
    page.keyboard.press("Escape")  # gives the arrows back, and does not end the presentation
    expect(page.locator(".presenter-arrows")).to_have_count(0)
    page.keyboard.press("ArrowLeft")
    at(page, "#log-odds/3")
    page.keyboard.press("b")
    expect(page.locator(".blank-screen")).to_be_visible()
    page.keyboard.press("b")
    expect(page.locator(".blank-screen")).to_have_count(0)
    page.keyboard.press("Escape")
    expect(page.locator(".presenter")).to_have_count(0)
    at(page, "/lecture.html#log-odds")
    expect(page.locator("#log-odds h2")).to_be_in_viewport()


def test_a_dragged_handle_follows_the_pointer_on_an_enlarged_slide(page: Page, server: str) -> None:
    page.set_viewport_size({"width": 1920, "height": 1080})
    present(page, server, "#rays/4")
    settle(page)
    room = page.locator("#rays .lesson-room").evaluate("e => e.clientHeight")
    figure = page.locator("#rays .lesson-figure").bounding_box()
    assert figure
    assert figure["height"] > 0.9 * room  # it is as large as the slide allows
    handle = page.get_by_role("slider", name="Last cell of the line")
    dot = handle.locator("circle").last
    box = dot.bounding_box()
    assert box
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    drag_along(page, (x, y), (x - 200, y + 120), steps=4)
    after = dot.bounding_box()
    assert after
    cell = page.locator("#rays .stage").evaluate("e => e.getBoundingClientRect().width") / 26
    assert after["x"] - box["x"] == pytest.approx(-200, abs=cell)
    assert after["y"] - box["y"] == pytest.approx(120, abs=cell)


def test_a_printed_slide_has_its_title_and_its_picture(page: Page, server: str) -> None:
    page.goto(f"{server}/lecture.html?present")
    expect(page.locator(".title-map canvas")).to_be_visible()
    page.emulate_media(media="print")
    page.evaluate("() => dispatchEvent(new Event('beforeprint'))")
    expect(page.get_by_role("heading", name="Occupancy grid mapping")).to_be_visible()
    expect(page.locator(".presenter-tools")).to_be_hidden()
    until("the map", lambda: (page.locator(".title-map canvas").bounding_box() or {"height": 0})["height"] > 200)


def test_the_derivation_comes_line_by_line(page: Page, server: str) -> None:
    present(page, server, "#cell-derivation/2")
    lines = page.locator("#cell .derivation-line")
    expect(lines).to_have_count(5)
    for i in range(5):
        expect(lines.nth(i)).to_be_visible(visible=i < 2)
    page.keyboard.press("Space")
    expect(lines.nth(2)).to_be_visible()
    expect(page.locator("#cell figure")).to_be_hidden()


# --- the speaker's window --------------------------------------------------------------------------------------------


def test_the_speakers_window_shows_notes_and_the_next_slide(page: Page, server: str) -> None:
    present(page, server, "#cell")
    with page.expect_popup() as opened:
        page.get_by_role("button", name="Speaker’s window").click()
    speaker = opened.value
    expect(speaker.get_by_role("heading", name="One cell")).to_be_visible()
    expect(speaker.locator(".speaker-text")).to_contain_text("Let the audience count")
    now, later = (
        speaker.frame_locator(f"iframe[title='{title}']") for title in ("The present slide", "What comes next")
    )
    expect(now.locator(".slide-question-text")).to_be_visible()
    expect(later.locator(".slide-option").first).to_be_visible()
    # Both windows turn the pages, and the server is not asked.
    page.context.set_offline(True)
    speaker.keyboard.press("PageDown")
    expect(page.locator(".slide-option").first).to_be_visible()
    speaker.get_by_role("button", name="Blank").click()
    expect(page.locator(".blank-screen")).to_be_visible()
    page.keyboard.press("PageDown")
    expect(now.locator("#cell figure")).to_be_visible()
    expect(speaker.get_by_role("button", name="Blank")).to_have_attribute("aria-pressed", "false")
    page.context.set_offline(False)
    assert violations(speaker) == []
    assert small(speaker) == []


def drag_to(page: Page, grip: Locator, onto: Locator) -> None:
    """Drag the row of a grip above the middle of another one's."""
    (x, y), box = still(grip), onto.bounding_box()
    assert box is not None
    drag_along(page, (x, y), (box["x"] + box["width"] / 2, box["y"] + 0.2 * box["height"]), steps=4)


# --- decks -----------------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_the_lecturer_arranges_a_deck_and_keeps_it(page: Page, server: str, tmp_path: Path) -> None:
    present(page, server)
    total = int(page.locator(".presenter-number").inner_text().split("/")[1])
    page.get_by_role("button", name="Arrange the slides").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("button", name="Move “One cell” up").click()
    dialog.get_by_role("button", name="Hide “Sonar cones”").click()
    dialog.get_by_text("Add a slide").click()
    dialog.get_by_role("textbox", name="Title").fill("Exercises")
    dialog.get_by_label("Text:").fill("- One\n- Two\n\nUntil Friday.")
    dialog.get_by_label("Notes").fill("Hand out the sheet.")
    dialog.get_by_role("button", name="Add at the end").click()
    expect(dialog.locator(".deck-row")).to_have_count(total + 1)
    # a link of the lab, and one that is none
    dialog.get_by_text("the lab", exact=True).click()
    dialog.get_by_role("textbox", name="Title").fill("A room")
    dialog.get_by_label("Link of the lab").fill("https://example.org/lab.html")
    dialog.get_by_role("button", name="Add at the end").click()
    expect(dialog.get_by_role("alert").first).to_contain_text("of example.org")
    dialog.get_by_label("Link of the lab").fill(f"{server}/lab.html#s=abc")
    dialog.get_by_role("button", name="Add at the end").click()
    expect(dialog.locator(".deck-row")).to_have_count(total + 2)
    nothing_wrong(page, ".deck-dialog")  # the slide behind it is inert
    assert small(page) == []
    # a slide is dragged by its grip, or goes by the arrow keys, and its picture is beside the list
    grips = dialog.locator(".deck-grip")
    titles = dialog.locator(".deck-row-title")
    first = titles.first.evaluate("(title) => title.firstChild.textContent.trim()")
    grips.first.focus()
    page.keyboard.press("ArrowDown")
    expect(titles.nth(1)).to_contain_text(first)
    expect(grips.nth(1)).to_be_focused()
    expect(dialog.get_by_role("status")).to_have_text(f"“{first}” is slide 2 of {total + 2}.")
    drag_to(page, grips.nth(1), grips.first)
    expect(titles.first).to_contain_text(first)
    expect(dialog.locator(".deck-picture figcaption")).to_have_text(f"1: {first}")
    expect(dialog.get_by_role("img", name=f"Picture of “{first}”")).to_be_visible()
    # a slide of one's own can be changed again
    dialog.get_by_role("button", name="Edit “A room”").click()
    form = dialog.locator(".deck-row .deck-form")
    expect(form.get_by_label("Link of the lab")).to_have_value("/lab.html#s=abc")
    form.get_by_role("textbox", name="Title").fill("A small room")
    form.get_by_role("button", name="Save the slide").click()
    expect(titles.last).to_contain_text("A small room")
    with page.expect_download() as saved:
        dialog.get_by_role("button", name="Save as file").click()
    file = tmp_path / "deck.json"
    saved.value.save_as(file)
    kept = json.loads(file.read_text())
    sections = [slide.get("section") for slide in kept["slides"]]
    assert sections.index("cell") == sections.index("grid") - 1
    assert kept["slides"][-2:] == [
        {"kind": "text", "title": "Exercises", "text": "- One\n- Two\n\nUntil Friday.", "notes": "Hand out the sheet."},
        {"kind": "lab", "title": "A small room", "address": "/lab.html#s=abc"},
    ]
    dialog.get_by_role("button", name="Close").click()
    # The address names the deck and its slide; it opens there again.
    page.keyboard.press("End")
    page.keyboard.press("Shift+ArrowLeft")
    expect(page).to_have_url(re.compile(r"#own-text&kept=\w{8}\.\d+$"))
    link = page.url
    page.goto("about:blank")
    page.goto(link)
    expect(page.locator(".own-text h2")).to_have_text("Exercises")
    expect(page.locator(".own-text li")).to_have_count(2)
    expect(page.get_by_text("Until Friday.")).to_be_hidden()
    page.keyboard.press("ArrowRight")
    expect(page.get_by_text("Until Friday.")).to_be_visible()
    # the hidden slide is left out
    assert f"/ {total + 1}" in page.locator(".presenter-number").inner_text()
    # a bad file is refused with its reason, a good one is taken
    page.get_by_role("button", name="Arrange the slides").click()
    bad = tmp_path / "bad.json"
    bad.write_text(json.dumps(kept | {"slides": [{"kind": "section", "section": "gird"}]}))
    dialog.get_by_label("File of a deck").set_input_files(bad)
    expect(dialog.get_by_text("was not loaded")).to_have_text(
        "“bad.json” was not loaded. Slide 1: the lecture has no section “gird”."
    )
    expect(dialog.locator(".deck-row")).to_have_count(total + 2)
    dialog.get_by_role("button", name="Whole lecture").click()
    expect(dialog.locator(".deck-row")).to_have_count(total)
    dialog.get_by_label("File of a deck").set_input_files(file)
    expect(dialog.locator(".deck-row")).to_have_count(total + 2)


# The colours of a picture, each as a number, with the share of pixels that have the most frequent one.
_COLOURS = """async (image) => {
  await image.decode();
  const canvas = new OffscreenCanvas(image.naturalWidth, image.naturalHeight), context = canvas.getContext("2d");
  context.drawImage(image, 0, 0);
  const pixels = new Uint32Array(context.getImageData(0, 0, canvas.width, canvas.height).data.buffer);
  const counts = new Map();
  for (const pixel of pixels) counts.set(pixel, (counts.get(pixel) ?? 0) + 1);
  return [counts.size, Math.max(...counts.values()) / pixels.length];
}"""


# How many boxes of an element have a scroll bar, itself among them.
_SCROLLED = """(root) => [root, ...root.querySelectorAll("*")].filter((box) =>
  /auto|scroll/.test(getComputedStyle(box).overflowY) && box.scrollHeight > box.clientHeight + 1).length"""


def test_the_rows_in_view_have_pictures_of_their_slides(page: Page, server: str) -> None:
    page.set_viewport_size({"width": 1024, "height": 700})
    present(page, server)
    page.get_by_role("button", name="Arrange the slides").click()
    dialog = page.get_by_role("dialog")
    assert dialog.evaluate(_SCROLLED) == 1
    dialog.get_by_text("Add a slide").click()
    assert dialog.evaluate(_SCROLLED) == 1
    dialog.get_by_text("Add a slide").click()
    expect(dialog.get_by_role("img", name="Picture of “Occupancy grid mapping”")).to_be_visible()
    page.set_viewport_size({"width": 1440, "height": 900})
    rows = page.locator(".deck-row")
    pictures = [rows.nth(i).locator("img") for i in range(4)]
    for picture in pictures:
        expect(picture).to_be_visible()
        colours, most = picture.evaluate(_COLOURS)
        assert colours > 50
        assert most < 0.9
    addresses = [picture.get_attribute("src") for picture in pictures]
    assert len(set(addresses)) == len(addresses)
    # a row that is not in view has none, until it is
    expect(rows.last.locator("img")).to_have_count(0)
    rows.last.scroll_into_view_if_needed()
    expect(rows.last.locator("img")).to_be_visible()
    # a picture moves with its slide, and is not made again
    rows.first.scroll_into_view_if_needed()
    rows.first.locator(".deck-grip").focus()
    page.keyboard.press("ArrowDown")
    expect(rows.nth(1).locator("img")).to_have_attribute("src", str(addresses[0]))
    expect(rows.first.locator("img")).to_have_attribute("src", str(addresses[1]))


def test_a_damaged_link_of_a_deck_says_so(page: Page, server: str) -> None:
    present(page, server, "#&deck=abc")
    expect(page.locator(".toast")).to_contain_text("incomplete or damaged")
    expect(page.locator(".title-map canvas")).to_be_visible()


def test_a_slide_with_the_lab_says_that_it_loads(page: Page, server: str) -> None:
    held: list[Route] = []
    new_world = re.compile(r"/api/sessions(\?.*)?$")
    page.route(new_world, lambda route: held.append(route))  # noqa: PLW0108 - Playwright marks the function
    with page.expect_request(new_world):
        present(page, server, "#own-lab")
        expect(page.locator(".own-lab").get_by_role("status")).to_have_text("Loading the lab …")
        expect(page.locator("iframe.slide-frame")).to_have_css("opacity", "0")
    said = page.locator(".own-lab > [role=status]")
    frame = page.locator("iframe.slide-frame")
    lab = page.frame_locator("iframe.slide-frame")
    # it takes long: the lab says why, and is not covered
    expect(said).to_have_count(0)
    expect(frame).to_have_css("opacity", "1")
    expect(lab.get_by_text("The first start on a server compiles the mapping functions")).to_be_visible()
    expect(lab.locator(".ghost").first).to_be_visible()
    held[0].continue_()
    expect(lab.locator("figure.profile")).to_be_visible()
    expect(lab.locator(".ghost")).to_have_count(0)


def test_the_lab_is_loaded_while_the_slide_before_it_is_shown(page: Page, server: str) -> None:
    present(page, server, "#terrain/4")
    frame = page.locator("iframe.slide-frame")
    expect(frame).to_be_hidden()
    inside = page.frame_locator("iframe.slide-frame")
    expect(inside.locator("figure.profile")).to_be_attached()  # the last part of the page
    frame.evaluate("frame => { frame.contentWindow.wasLoadedAhead = true; }")
    page.keyboard.press("ArrowRight")
    expect(frame).to_be_visible()
    assert frame.evaluate("frame => frame.contentWindow.wasLoadedAhead") is True
    page.keyboard.press("ArrowRight")
    expect(frame).to_have_count(0)


# --- what is on them -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("every", "axe_every", "turn"),
    [(13, 3, 0), *(pytest.param(1, 1, turn, marks=pytest.mark.long) for turn in (0, 1))],
)
def test_every_slide_is_large_enough_complete_and_accessible(
    page: Page, server: str, every: int, axe_every: int, turn: int
) -> None:
    """One slide in ``every`` is shown, and axe looks at one in ``axe_every`` of those."""
    page.set_viewport_size({"width": 1920, "height": 1080})
    names = slide_ids(page, server)[::every]

    def show(name: str) -> None:
        page.goto(f"{server}/lecture.html?present#{name}/99")  # within the page, which is not loaded again
        settle(page)

    # The whole lecture is laid out again when the window changes: once for all slides.
    small = {}
    for name in names:
        show(name)
        small[name] = small_texts(page, LABEL_PX)
    page.set_viewport_size({"width": 1024, "height": 768})  # the smallest projector
    cut_there = {}
    for name in names:
        show(name)
        cut_there[name] = cut_off(page)
    page.set_viewport_size({"width": 1280, "height": 720})
    problems = {}
    for i, name in enumerate(names):
        show(name)
        cut, found = cut_there[name] + cut_off(page), []
        if i % axe_every == 0:
            # Each slide in one of the themes, `make test-long` in both: what they share is looked at in both.
            page.emulate_media(color_scheme="light" if (i // axe_every + turn) % 2 else "dark")
            found = violations(page)
        if small[name] or cut or found:
            problems[name] = (small[name], cut, found)
    assert problems == {}


@pytest.mark.parametrize("context", ["phone"], indirect=True)
def test_slides_on_a_phone_scroll_and_are_not_wider(page: Page, server: str) -> None:
    for name in ("grid/2", "model/4", "cell-derivation/5", "file/4"):
        present(page, server, f"#{name}")
        settle(page)
        # clientWidth: a phone's innerWidth grows with a page that is too wide
        root = "document.documentElement"
        assert page.evaluate(f"{root}.scrollWidth <= {root}.clientWidth + 1"), name
        expect(page.locator(".presenter")).to_be_in_viewport(ratio=1)


def test_the_page_leads_into_the_presentation_and_the_front_page_here(page: Page, server: str) -> None:
    page.goto(server)
    page.get_by_role("link", name="Open the lecture").click()
    expect(page.get_by_role("heading", name="Occupancy grid mapping")).to_be_visible()
    page.get_by_role("button", name="Presentation mode").click()
    expect(page.locator(".presenter")).to_be_visible()
    page.get_by_role("button", name="Exit").click()
    expect(page.get_by_role("heading", name="Occupancy grid mapping")).to_be_attached()
