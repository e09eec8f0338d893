"""A field engineer's job on one page: from the upload to the printed report in at most 25 clicks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.looking import await_map, await_true, frame, until
from tests.browser.test_clip_handles import CUT, by_mouse, ceiling_handle
from tests.mapper.io.contents.recorded_robot import T0, robot
from tests.mapper.io.contents.test_pictures import image
from tests.mapper.io.logs import recorded

MOST = 25


class Clicks:
    """Counts clicks; a choice from a list is two."""

    def __init__(self) -> None:
        self.count = 0

    def on(self, target: Locator, **options: object) -> None:
        target.click(**options)  # type: ignore[arg-type]
        self.count += 1

    def choose(self, target: Locator, label: str) -> None:
        target.select_option(label=label)
        self.count += 2


@pytest.mark.long
@pytest.mark.moving
def test_from_the_upload_to_the_report(page: Page, server: str, tmp_path: Path) -> None:
    camera = [image(np.full((48, 64), 60 * n, dtype=np.uint8), "mono8", T0 + n * recorded.SECOND) for n in range(3)]
    line = recorded.log_line(T0 + 2 * recorded.SECOND, 40, "Bumper pressed", "bumper")
    away = np.random.default_rng(0).normal(size=(6000, 3))
    away /= np.linalg.norm(away, axis=1)[:, None]
    walls = away * np.min(np.array([3.0, 2.5, 1.5]) / np.abs(away), axis=1)[:, None]
    clouds = [recorded.cloud(T0 + n * recorded.SECOND, walls, frame="base_link") for n in range(3)]
    (tmp_path / "robot.mcap").write_bytes(recorded.mcap_bytes([*robot(3), *camera, *clouds, line]))
    clicks = Clicks()
    page.goto(f"{server}/logs.html")
    page.locator("input[type=file]").set_input_files(tmp_path / "robot.mcap")
    clicks.count += 2  # the field and the file
    await_map(page)
    page.evaluate("() => gridbloom.connection.store.send({ type: 'pause' })")
    until("the log to stand", lambda: not frame(page)["playing"])

    # Camera, map, speed and what nodes logged, at the moment of the push.
    clicks.choose(page.get_by_label("Layout", exact=True), "Diagnosis")
    clicks.choose(page.locator(".lines-search").get_by_label("Level"), "error and above")
    clicks.on(page.locator(".log-line", has_text="Bumper pressed"))
    until("the moment of the push", lambda: abs(frame(page)["stamp"] - 2.0) < 0.06)
    expect(page.get_by_role("region", name="Pictures").get_by_role("img")).to_have_attribute("alt", "/camera at 2.00 s")
    plots = page.get_by_role("region", name="Plots", exact=True)
    clicks.choose(plots.get_by_label("Topic"), "/odom (nav_msgs/Odometry)")
    expect(plots.locator("[data-plot=speed]")).to_contain_text("m/s")

    # A door is measured.
    clicks.on(page.get_by_role("button", name="Measure a distance"))
    picture = page.locator(".picture")
    for x in (0.3, 0.7):
        size = picture.bounding_box()
        assert size is not None
        clicks.on(picture, position={"x": x * size["width"], "y": 0.35 * size["height"]})
    expect(page.get_by_role("region", name="Measured")).to_contain_text("±")
    clicks.on(page.get_by_role("button", name="Close the ruler"))

    # The ceiling is clipped, beside the log.
    with page.expect_popup() as beside:
        clicks.on(page.get_by_role("link", name="Open in 3D"))
    solid = beside.value
    await_true(solid, "() => window.gridbloom?.connection.store.part('volume').message.peek()?.chunks > 0")
    clicks.on(solid.get_by_role("button", name="Clip", exact=True))
    until("the handles are drawn", lambda: ceiling_handle(solid) is not None)
    handle = ceiling_handle(solid)
    assert handle is not None
    whole = solid.evaluate(CUT)
    by_mouse(solid, handle, 60.0, lambda: await_true(solid, f"() => ({CUT})() < {whole} - 0.3"))
    clicks.count += 1
    solid.close()

    # A note, a link, and the report.
    clicks.on(page.get_by_role("tab", name="Notes"))
    clicks.on(page.get_by_label("New note"))
    page.keyboard.type("pushed here")
    clicks.on(page.get_by_role("button", name="Add note"))
    expect(page.locator(".timeline-mark")).to_have_count(1)
    clicks.on(page.get_by_role("tab", name="Share", exact=True))
    clicks.on(page.get_by_role("button", name="Create link"))
    expect(page.get_by_label("Address of the link of")).to_have_count(1)
    clicks.on(page.get_by_role("tab", name="Download"))
    with page.expect_popup() as opened:
        clicks.on(page.get_by_role("link", name="Report"))
    report = opened.value
    expect(report.get_by_role("heading", level=1)).to_have_text("robot.mcap")
    expect(report.get_by_role("main")).to_contain_text("pushed here")
    expect(report.get_by_role("img", name="Picture of /camera")).to_be_visible()
    clicks.count += 1  # the browser's print
    assert clicks.count <= MOST, clicks.count
