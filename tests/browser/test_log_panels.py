"""Panels of the log page on the contents of a recording: topics, plots, frames, trajectories, notes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from playwright.sync_api import Page, expect

from tests.browser.looking import await_map, frame, open_group, until
from tests.mapper.io.contents.recorded_robot import T0, robot
from tests.mapper.io.contents.test_pictures import image
from tests.mapper.io.logs import recorded

SECONDS = 4


def seek(page: Page, index: int) -> None:
    page.evaluate("(index) => gridbloom.connection.store.send({ type: 'pause' })")
    page.evaluate("(index) => gridbloom.connection.store.send({ type: 'seek', index })", index)
    until("the moment", lambda: frame(page)["index"] == index)


def test_what_a_recording_holds(page: Page, server: str, tmp_path: Path) -> None:
    camera = image(np.full((48, 64), 200, dtype=np.uint8), "mono8", T0 + recorded.SECOND // 2)
    (tmp_path / "robot.mcap").write_bytes(recorded.mcap_bytes([*robot(SECONDS), camera]))
    page.emulate_media(reduced_motion="reduce")  # the log stands
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
    expect(picture).to_have_attribute("alt", "/camera at 0.50 s")
    until("the picture", lambda: picture.evaluate("(img) => [img.naturalWidth, img.naturalHeight]") == [64, 48])

    # A click on a plot goes to that moment: at half of the width to half of the time.
    plots = open_group(page, "Plots")
    over = plots.locator('[data-plot="angular velocity"] .u-over')
    expect(over).to_be_visible()
    box = over.bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    until("the middle of the log", lambda: abs(frame(page)["index"] - 5 * SECONDS) <= 2)

    frames = open_group(page, "Frames")
    seek(page, 10)
    expect(frames.get_by_role("img")).to_have_attribute(
        "aria-label", "Fixed frame odom. laser in base_link, static; base_link in odom, 10.0 Hz, 0 ms old."
    )
    expect(frames).to_contain_text("Transforms lead from the sensor's frame, laser, to odom.")

    # A trajectory that is brought is compared with the log's own.
    lines = [f"{1_700_000_000 + i / 10:.1f} {0.1 * i} 0.2 0 0 0 0 1" for i in range(10 * SECONDS)]
    (tmp_path / "better.tum").write_text("\n".join(lines))
    trajectories = open_group(page, "Trajectories")
    trajectories.get_by_label("TUM files").set_input_files(tmp_path / "better.tum")
    expect(trajectories).to_contain_text("better was added.")
    trajectories.get_by_label("Compared with it").select_option("better")
    trajectories.get_by_text("Not aligned").click()
    absolute = trajectories.get_by_role("row").filter(has_text="Absolute, m").get_by_role("cell")
    expect(absolute.last).to_have_text("0.200")
    expect(page.locator(".error-legend")).to_contain_text("0.20 m")

    notes = open_group(page, "Notes")
    expect(page.locator(".error-legend")).to_have_count(0)
    notes.get_by_label("New note").fill("the door opens")
    notes.get_by_role("button", name="Add note").click()
    mark = page.locator(".timeline-mark")
    expect(mark).to_have_attribute("aria-label", "Note: the door opens")
    page.evaluate("() => { gridbloom.connection.store.pinned.value = [1, 0.5]; }")
    notes.get_by_label("New note").fill("a glass wall")
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
