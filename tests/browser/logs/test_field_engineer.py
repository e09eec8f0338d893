"""A field engineer's job on one page, from the upload to the printed report: by mouse in at most 25 clicks, by finger,
and by the keyboard alone.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Locator, Page, expect

from mapper.simulation import WORLDS, SensorConfig
from mapper.simulation.lidar import measure
from tests.browser.logs.test_clip_handles import by_finger, by_mouse, ceiling_handle
from tests.browser.looking import await_map, await_true, frame, until
from tests.browser.pages.test_targets import small
from tests.mapper.io.contents.recorded_robot import T0, command
from tests.mapper.io.contents.test_pictures import image
from tests.mapper.io.logs import recorded

RATE_HZ, SCANS = 5, 80
SENSOR = SensorConfig(n_beams=360, range_max=8.0, range_noise=0.01, scan_rate=RATE_HZ)
START = (2.9, 7.0)  #: of the robot in the world's frame: in the corridor of the office, along which it drives
STEP_M = 0.1  #: a scan
PUSHED_AT, PUSH_M = 40, 0.40  #: the scan from which it is pushed to its right, for two scans
PUSHED_S = PUSHED_AT / RATE_HZ
DOOR = ((0.5, -1.0), (1.45, -1.0))  #: its sides in the frame odom, where the robot began; it is 0.95 m wide
DOOR_M, CELL_M = 0.95, 0.05

CUT_OF_CLOUDS = "() => gridbloom.clouds.store.part('volume').message.peek().look.values.cut_high"

MOST = 25
MOST_STOPS = 400  #: of the key Tab on a page


class Mouse:
    """Presses with the mouse, and counts clicks: a choice from a list is two, a drag is one."""

    def __init__(self) -> None:
        self.count = 2  # the field of the file, and the file

    def press(self, target: Locator) -> None:
        target.click()
        self.count += 1

    def choose(self, target: Locator, label: str) -> None:
        target.select_option(label=label)
        self.count += 2

    def open_tab(self, page: Page, name: str) -> None:
        self.press(page.get_by_role("tab", name=name, exact=True))

    def measure(self, picture: Locator) -> None:
        """Choose the two sides of the door on the map."""
        size = picture.bounding_box()
        assert size is not None
        for side in DOOR:
            x, y = picture.page.evaluate(
                """([x, y]) => { const view = gridbloom.connection.store.view.peek();
                return [(x - view.x) / view.scale, (view.y - y) / view.scale]; }""",
                list(side),
            )
            self._press_at(picture, size["width"] / 2 + x, size["height"] / 2 + y)
            self.count += 1

    def _press_at(self, picture: Locator, x: float, y: float) -> None:
        picture.click(position={"x": x, "y": y})

    def clip(self, view: Locator) -> None:
        """Drag the upper face of the clip box down."""
        page = view.page
        self.press(view.get_by_role("button", name="Clip", exact=True))
        until("the handles are drawn", lambda: ceiling_handle(page) is not None)
        handle = ceiling_handle(page)
        assert handle is not None
        whole = page.evaluate(CUT_OF_CLOUDS)
        self.drag(page, handle, 60.0, lambda: await_true(page, f"() => ({CUT_OF_CLOUDS})() < {whole} - 0.3"))
        self.count += 1

    drag = staticmethod(by_mouse)


class Finger(Mouse):
    """Presses with a finger."""

    def press(self, target: Locator) -> None:
        target.tap()

    def _press_at(self, picture: Locator, x: float, y: float) -> None:
        picture.tap(position={"x": x, "y": y})

    drag = staticmethod(by_finger)


class Keys(Mouse):
    """Uses the keyboard alone: what it presses is reached by Tab, a tab from the selected one by the arrow keys."""

    def reach(self, target: Locator) -> None:
        """Move the focus to an element, forward or back as it stands on the page; it must be seen there."""
        target.wait_for()
        keyboard = target.page.keyboard
        for _ in range(MOST_STOPS):
            where = target.evaluate(
                """(one) => one === document.activeElement ? "" :
                (document.activeElement ?? document.body).compareDocumentPosition(one) & 2 ? "Shift+Tab" : "Tab\""""
            )
            if where == "":
                assert target.evaluate("(one) => one.matches(':focus-visible')"), "the focus is not shown"
                return
            keyboard.press(where)
        raise AssertionError(f"the key Tab does not lead to {target}")

    def press(self, target: Locator) -> None:
        self.reach(target)
        target.page.keyboard.press("Enter")

    def choose(self, target: Locator, label: str) -> None:
        self.reach(target)
        for _ in range(target.locator("option").count()):
            if target.evaluate("(one) => one.selectedOptions[0]?.label") == label:
                return
            target.page.keyboard.press("ArrowDown")
        expect(target.locator("option:checked")).to_have_text(label)

    def open_tab(self, page: Page, name: str) -> None:
        wanted = page.get_by_role("tab", name=name, exact=True)
        tabs = page.get_by_role("tablist").filter(has=wanted)
        self.reach(tabs.get_by_role("tab", selected=True))
        for _ in range(tabs.get_by_role("tab").count()):
            if wanted.get_attribute("aria-selected") == "true":
                return
            page.keyboard.press("ArrowRight")
        expect(wanted).to_have_attribute("aria-selected", "true")

    def measure(self, picture: Locator) -> None:
        self.reach(picture)
        keyboard = picture.page.keyboard
        keyboard.press("ArrowUp")  # a cursor, at the robot
        keyboard.press("Enter")
        for _ in range(5):
            keyboard.press("ArrowLeft")
        keyboard.press("Enter")

    def clip(self, view: Locator) -> None:
        page = view.page
        whole = page.evaluate(CUT_OF_CLOUDS)
        self.press(view.get_by_text("Colours and clip box"))
        self.reach(view.get_by_role("slider", name="Cut above"))
        for _ in range(6):
            page.keyboard.press("PageDown")
        await_true(page, f"() => ({CUT_OF_CLOUDS})() < {whole} - 0.3")


def drive() -> Iterator[recorded.Said]:
    """A drive along the corridor of the simulated office; a push that the wheels do not measure presses the bumper."""
    random = np.random.default_rng(1)
    away = np.random.default_rng(0).normal(size=(6000, 3))
    away /= np.linalg.norm(away, axis=1)[:, None]
    walls = away * np.min(np.array([3.0, 2.5, 1.5]) / np.abs(away), axis=1)[:, None]
    yield recorded.transform(T0, "base_link", "laser", topic="/tf_static")
    for n in range(SCANS):
        at = T0 + n * recorded.SECOND // RATE_HZ
        aside = PUSH_M * min(1.0, max(0.0, (n - PUSHED_AT) / 2))
        pose = (START[0] + STEP_M * n, START[1] - aside, 0.0)
        ranges = measure(WORLDS["office"], SENSOR, pose, random).ranges
        yield recorded.scan(at, ranges, angles=(SENSOR.angle_min, SENSOR.angle_increment), limits=(0.1, 8.0))
        yield recorded.odometry(at, STEP_M * n, 0.0, 0.0)
        yield recorded.transform(at, "odom", "base_link", STEP_M * n)
        yield command(at, 0.0 if PUSHED_AT <= n < PUSHED_AT + 3 else STEP_M * RATE_HZ, 0.0)
        if n % RATE_HZ == 0:
            yield image(np.full((48, 64), 10 * n // RATE_HZ, dtype=np.uint8), "mono8", at)
        if n < 3:
            yield recorded.cloud(at, walls, frame="base_link")
        if n == PUSHED_AT:
            yield recorded.log_line(at, 40, "Bumper pressed", "bumper")


@pytest.mark.long
@pytest.mark.moving
@pytest.mark.parametrize(
    ("context", "hand"),
    [("desktop", Mouse), ("phone", Finger), ("tablet", Finger), ("desktop", Keys)],
    indirect=["context"],
    ids=["mouse", "finger on a phone", "finger on a tablet", "keyboard"],
)
def test_from_the_upload_to_the_report(hand: type[Mouse], page: Page, server: str, tmp_path: Path) -> None:
    (tmp_path / "robot.mcap").write_bytes(recorded.mcap_bytes(drive()))
    by = hand()
    page.goto(f"{server}/logs.html")
    page.locator("input[type=file]").set_input_files(tmp_path / "robot.mcap")
    await_map(page)
    page.evaluate("() => gridbloom.connection.store.send({ type: 'pause' })")
    until("the log to stand", lambda: not frame(page)["playing"])

    # The push among the events, and camera, map, speed and what nodes logged at its moment.
    event = page.get_by_role("region", name="Events", exact=True).locator("[data-event=pushed]")
    expect(event).to_contain_text(re.compile(r"Pushed 0\.(39|40|41) m right"))
    by.press(event.get_by_role("button"))
    until("the moment of the push", lambda: abs(frame(page)["stamp"] - PUSHED_S) <= 1.0 / RATE_HZ)
    by.choose(page.get_by_label("Layout", exact=True), "Moment")
    lines = page.get_by_role("region", name="Log lines", exact=True)
    by.choose(lines.get_by_label("Level"), "error and above")
    if isinstance(by, Keys):
        by.reach(lines.get_by_role("listbox"))
        page.keyboard.press("ArrowDown")
    else:
        by.press(lines.locator(".log-line", has_text="Bumper pressed"))
    until("the moment of the line", lambda: frame(page)["stamp"] == PUSHED_S)
    expect(page.get_by_role("region", name="Pictures").get_by_role("img")).to_have_attribute(
        "alt", "/camera at 0:08.000"
    )
    plots = page.get_by_role("region", name="Plots", exact=True)
    speed = plots.get_by_role("region", name="Plot of any field")
    expect(speed.get_by_role("list", name="Fields of the plot")).to_contain_text("speed")
    expect(speed).to_contain_text(f"{STEP_M * RATE_HZ:g} m/s throughout")

    # A door is measured.
    by.press(page.get_by_role("button", name="Measure a distance"))
    by.measure(page.locator(".picture"))
    measured = page.get_by_role("region", name="Measured")
    expect(measured).to_contain_text("± 0.05 m")
    if not isinstance(by, Keys):  # they measure from the robot on
        width = float(re.findall(r"(\d\.\d\d) m ±", measured.inner_text())[0])
        assert width == pytest.approx(DOOR_M, abs=CELL_M + 1e-9)
    by.press(page.get_by_role("button", name="Close the ruler"))

    # The ceiling is clipped, beside the map.
    by.press(page.get_by_role("link", name="Open in 3D"))
    await_true(page, "() => gridbloom.clouds?.store.part('volume').message.peek()?.chunks > 0")
    by.clip(page.get_by_role("region", name="3D", exact=True))

    # A note, a link, and the report.
    by.open_tab(page, "Notes")
    by.press(page.get_by_label("New note"))
    page.keyboard.type("pushed here")
    by.press(page.get_by_role("button", name="Add note"))
    expect(page.locator(".timeline-mark")).to_have_count(1)
    by.open_tab(page, "Share")
    by.press(page.get_by_role("button", name="Create link"))
    expect(page.get_by_label("Address of the link of")).to_have_count(1)
    by.open_tab(page, "Download")
    with page.expect_popup() as opened:
        by.press(page.get_by_role("link", name="Report", exact=True))
    report = opened.value
    expect(report.get_by_role("heading", level=1)).to_have_text("robot.mcap")
    expect(report.get_by_role("main")).to_contain_text("pushed here")
    expect(report.get_by_role("main")).to_contain_text("m to its right, which the wheels did not measure")
    expect(report.get_by_role("img", name="Picture of /camera")).to_be_visible()
    by.count += 1  # the browser's print
    if hand is Mouse:
        assert by.count <= MOST, by.count
    elif hand is Finger:
        assert small(page) == []
        assert small(report) == []
