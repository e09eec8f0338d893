"""Panels of the log page on the contents of a recording: topics, plots, frames, trajectories, notes."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
from playwright.sync_api import APIResponse, Page, Route, expect

from tests.browser.looking import await_map, centre, drag_along, frame, open_group, until
from tests.browser.pages.test_axe import violations
from tests.mapper.io.contents.recorded_robot import T0, robot
from tests.mapper.io.contents.test_pictures import image
from tests.mapper.io.logs import recorded

SECONDS = 4


def seek(page: Page, index: int) -> None:
    page.evaluate("(index) => gridbloom.connection.store.send({ type: 'pause' })")
    page.evaluate("(index) => gridbloom.connection.store.send({ type: 'seek', index })", index)
    until("the moment", lambda: frame(page)["index"] == index)


def plots_under_the_timeline(page: Page) -> None:
    """The cursor is that of the timeline both ways, a click goes to the moment, a drag zooms, and keys do the same."""
    page.get_by_role("button", name="Plots", exact=True).click()
    panel = page.get_by_role("region", name="Plots over the log")
    over = panel.locator('[data-strip="speed"] .u-over')
    expect(over).to_be_visible()
    expect(panel.locator('[data-strip="returns"] output')).to_have_text("100 %")
    expect(panel.locator('[data-strip="speed"] output')).to_have_text("1.00 m/s")  # 0.05 m in 0.05 s, twice
    page.wait_for_function("() => document.querySelector('.strips').clientWidth <= innerWidth")
    box = over.bounding_box()
    assert box is not None
    middle = box["y"] + 0.5 * box["height"]
    page.mouse.move(box["x"] + 0.25 * box["width"], middle)
    expect(page.locator(".timeline-preview")).to_have_text(re.compile(r"scan (9|10|11) · 0:00|scan 11 · 0:01"))
    page.mouse.click(box["x"] + 0.25 * box["width"], middle)
    until("a quarter of the log", lambda: abs(frame(page)["index"] - 10) <= 1)

    drag_along(page, (box["x"] + 0.5 * box["width"], middle), (box["x"] + 0.75 * box["width"], middle), steps=4)
    slider = panel.get_by_role("slider", name="Moment in the plots")
    until("the third quarter", lambda: abs(float(slider.get_attribute("aria-valuemin") or 0) - 1.95) < 0.1)
    expect(panel.get_by_role("button", name="Show the whole log")).to_be_enabled()

    page.mouse.move(5, 5)
    slider.focus()
    slider.press("End")
    expect(slider).to_have_attribute("aria-valuetext", re.compile(r"^0:0[23]\.\d{3}, scan (29|30|31). speed 1.00 m/s"))
    slider.press("Enter")
    until("the end of the interval", lambda: abs(frame(page)["index"] - 30) <= 1)
    slider.press("Escape")
    expect(panel.get_by_role("button", name="Show the whole log")).to_be_disabled()
    page.get_by_role("button", name="Plots", exact=True).click()
    expect(panel).to_have_count(0)


def test_what_a_recording_holds(page: Page, server: str, tmp_path: Path) -> None:
    camera = image(np.full((48, 64), 200, dtype=np.uint8), "mono8", T0 + recorded.SECOND // 2)
    (tmp_path / "robot.mcap").write_bytes(recorded.mcap_bytes([*robot(SECONDS), camera]))
    page.goto(f"{server}/logs.html")
    page.locator("input[type=file]").set_input_files(tmp_path / "robot.mcap")
    await_map(page)
    seek(page, 10)

    topics = open_group(page, "Topics")
    imu = topics.get_by_role("row").filter(has_text="/imu")
    expect(imu).to_contain_text("sensor_msgs/Imu")
    assert imu.get_by_role("cell").all_inner_texts()[:2] == [str(20 * SECONDS), "20.0 Hz"]
    expect(topics.get_by_role("row").filter(has_text="/scan")).to_contain_text("mapped")

    picture = open_group(page, "Pictures").get_by_role("img")
    expect(picture).to_have_attribute("alt", "/camera at 0:00.500")
    until("the picture", lambda: picture.evaluate("(img) => [img.naturalWidth, img.naturalHeight]") == [64, 48])

    # A click on a plot goes to that moment: at half of the width to half of the time.
    plots = open_group(page, "Plots")
    over = plots.locator('[data-plot="angular velocity"] .u-over')
    expect(over).to_be_visible()
    # The legend states the values at the map's moment while the pointer is elsewhere: that of the newest of ten scans.
    legend = plots.locator('[data-plot="angular velocity"] .u-legend')
    expect(legend).to_have_text(f"time0:00.900x0.000 rad/sy0.000 rad/sz−{abs(0.1 * math.sin(18)):.3f} rad/s")
    box = over.bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    until("the middle of the log", lambda: abs(frame(page)["index"] - 5 * SECONDS) <= 2)

    plots_under_the_timeline(page)

    held: list[Route] = []
    page.route("**/contents/fields", lambda route: held.append(route))  # noqa: PLW0108 (Playwright counts its arguments)
    frames = open_group(page, "Frames")
    seek(page, 10)
    expect(frames.get_by_role("img")).to_have_attribute(
        "aria-label", "Fixed frame odom. laser in base_link, static; base_link in odom, 10.0 Hz, 0 ms old."
    )
    expect(frames).to_contain_text("Transforms lead from the sensor’s frame, laser, to odom.")
    # No control moves when the names of the fields come, for which the whole file is read.
    expect(frames).to_contain_text("Looking up which frames messages name")
    choice = frames.get_by_label("Age over time of")
    before = choice.bounding_box()
    for route in held:
        route.continue_()
    page.unroute("**/contents/fields")
    expect(frames).not_to_contain_text("Looking up which frames messages name")
    assert choice.bounding_box() == before

    # A trajectory that is brought is compared with the log's own.
    lines = [f"{1_700_000_000 + i / 10:.1f} {0.1 * i} 0.2 0 0 0 0 1" for i in range(10 * SECONDS)]
    (tmp_path / "better.tum").write_text("\n".join(lines))
    trajectories = open_group(page, "Trajectories")
    trajectories.get_by_label("TUM files").set_input_files(tmp_path / "better.tum")
    expect(trajectories).to_contain_text("better was added.")
    trajectories.get_by_label("Compared with it").select_option("better")
    trajectories.get_by_text("Not aligned").click()
    absolute = trajectories.get_by_role("row").filter(has_text="Absolute (m)").get_by_role("cell")
    expect(absolute.last).to_have_text("0.200")
    expect(page.locator(".error-legend")).to_contain_text("0.20 m")

    notes = open_group(page, "Notes")
    expect(page.locator(".error-legend")).to_have_count(0)
    notes.get_by_label("New note").fill("the door opens")
    answers: list[
        tuple[Route, APIResponse]
    ] = []  # of the server, which tells all pages of the note before its answer is there
    post = re.compile("/notes$")
    page.route(
        post,
        lambda route: answers.append((route, route.fetch())) if route.request.method == "POST" else route.fallback(),
    )
    notes.get_by_role("button", name="Add note").click()
    mark = page.locator(".timeline-mark")
    expect(mark).to_have_attribute("aria-label", "Note: the door opens")
    notes.get_by_label("New note").fill("a glass wall")
    until("the answer", lambda: answers)
    with page.expect_response(post):
        answers[0][0].fulfill(response=answers[0][1])
    page.unroute(post)
    expect(notes.get_by_role("button", name="Add note")).to_be_enabled()
    page.evaluate("() => { gridbloom.connection.store.pinned.value = [1, 0.5]; }")
    notes.get_by_role("switch", name="At the cell that I click").click()
    notes.get_by_role("button", name="Add note").click()
    pin = page.get_by_role("button", name="Note: a glass wall").and_(page.locator(".note-pin"))
    expect(pin).to_be_visible()
    seek(page, 30)
    open_group(page, "Settings")
    pin.click()
    until("the moment of the note", lambda: frame(page)["index"] == 10)
    expect(page.locator(".note.chosen")).to_contain_text("a glass wall")
    notes.get_by_role("button", name="Delete this note").first.click()
    expect(page.locator(".timeline-mark")).to_have_count(1)

    # An area that is measured, by keys: Enter is a corner at the cell of the cursor.
    open_group(page, "Notes")
    notes.get_by_role("switch", name="Around the area").click()
    expect(notes).to_contain_text("click at least three corners")
    page.get_by_role("button", name="Measure an area").click()
    page.get_by_role("switch", name="Snap to walls").click()
    for corner in ((1.0, 0.0), (3.0, 0.0), (3.0, 1.5), (1.0, 1.5)):
        page.evaluate("(at) => { gridbloom.connection.store.pinned.value = at; }", corner)
        page.locator(".picture").press("Enter")
    notes.get_by_label("New note").fill("wet floor")
    expect(notes.get_by_role("switch", name="Around the area of 3.00 m²")).to_be_checked()
    notes.get_by_role("button", name="Add note").click()
    expect(notes.get_by_role("button", name=re.compile("Go to this note: .*3.00 m²"))).to_be_visible()
    expect(page.locator(".note-areas polygon")).to_have_count(1)
    with page.expect_download() as saved:
        notes.get_by_role("link", name="Download the notes as GeoJSON").click()
    features = json.loads(saved.value.path().read_text())["features"]
    ring = features[-1]["geometry"]["coordinates"][0]
    assert ring == [[1.0, 0.0], [3.0, 0.0], [3.0, 1.5], [1.0, 1.5], [1.0, 0.0]]
    assert violations(page, ".dock") == []


def test_an_overview_of_a_log_that_is_a_text(page: Page, server: str) -> None:
    """The overview of a log of another kind than a recording has its motion, which goes to a moment, and its topics."""
    page.goto(f"{server}/logs.html")
    lines = "".join(f"FLASER 3 1 2 3 {n**2 / 100} 0 0 {n**2 / 100} 0 0 {n} host {n}\n" for n in range(1, 62))
    page.locator("input[type=file]").set_input_files(
        {"name": "text.log", "mimeType": "text/plain", "buffer": lines.encode()}
    )
    page.locator(".viewer").wait_for()
    expect(page.get_by_role("region", name="Topics")).to_contain_text("FLASER")
    motion = page.get_by_role("region", name="Motion")
    expect(motion).to_contain_text("speed")
    page.evaluate("() => gridbloom.connection.store.send({ type: 'pause' })")
    plot = motion.locator('[data-strip="speed"] .u-over')
    page.mouse.click(*centre(plot))
    until("the middle of the log", lambda: frame(page)["index"] in (30, 31))
