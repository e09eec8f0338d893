"""An engineer's page: views beside each other, the ruler, times, and raw messages."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.browser.looking import (
    await_map,
    await_true,
    centre,
    frame,
    frames,
    map_bytes,
    open_group,
    open_sample,
    still,
    until,
    without_canvas_in_3d,
)
from tests.browser.pages.test_axe import LOOKS, violations
from tests.mapper.io.contents.recorded_robot import T0, robot
from tests.mapper.io.contents.test_pictures import image
from tests.mapper.io.logs import recorded
from tests.marks import also_long_rows

LINES = [(2, 20, "Ready"), (12, 30, "Wheel slips"), (15, 20, "Planning"), (21, 40, "Bumper pressed")]  # tenths of s

SCREEN = """(point) => {
  const { left, top } = document.querySelector(".picture").getBoundingClientRect();
  const [x, y] = gridbloom.screen(point);
  return [left + x, top + y];
}"""  # the place in the window of a point of the map


#: The places of the dashed lines in the plot of the speed, as shares of its width.
MARKED = """() => {
  const plot = document.querySelector('[data-strip="speed"]');
  const canvas = plot.querySelector("canvas");
  const [whole, over] = [canvas, plot.querySelector(".u-over")].map((one) => one.getBoundingClientRect());
  const scale = canvas.width / whole.width;
  const [left, top] = [over.left - whole.left, over.top - whole.top].map((at) => Math.round(at * scale));
  const [width, height] = [over.width, over.height].map((size) => Math.round(size * scale));
  const probe = document.createElement("span");
  probe.style.color = "var(--foreground)";
  plot.append(probe);
  const wanted = getComputedStyle(probe).color.match(/[\\d.]+/g).slice(0, 3).map(Number);
  probe.remove();
  const { data } = canvas.getContext("2d").getImageData(left, top, width, height);
  const found = [];
  for (let x = 0; x < width; x++) {
    let count = 0;
    for (let y = 0; y < height; y++) {
      const at = 4 * (y * width + x);
      if (data[at + 3] > 200 && wanted.every((one, k) => Math.abs(one - data[at + k]) < 40)) count++;
    }
    if (count > 0.3 * height) found.push(x);
  }
  const lines = found.filter((x, n) => n === 0 || x > found[n - 1] + 3);
  return lines.map((x) => (x + 0.5) / width);
}"""


def opened(page: Page, server: str, folder: Path, more: Sequence[recorded.Said] = ()) -> None:
    camera = image(np.full((48, 64), 200, dtype=np.uint8), "mono8", T0 + recorded.SECOND // 2)
    lines = [recorded.log_line(T0 + at * recorded.SECOND // 10, level, words) for at, level, words in LINES]
    (folder / "robot.mcap").write_bytes(recorded.mcap_bytes([*robot(3), camera, *lines, *more]))
    page.goto(f"{server}/logs.html")
    page.locator("input[type=file]").set_input_files(folder / "robot.mcap")
    await_map(page)
    page.evaluate("() => gridbloom.connection.store.send({ type: 'pause' })")
    until("the log to stand", lambda: not frame(page)["playing"])


def test_views_share_the_stage_and_the_time(page: Page, server: str, tmp_path: Path) -> None:
    opened(page, server, tmp_path)
    # Warnings and errors of nodes are marked on the slider before anybody looks at the lines.
    expect(page.locator(".timeline-tick")).to_have_count(2)
    expect(page.locator(".timeline-tick.grave")).to_have_count(1)
    page.keyboard.press("2")
    views = page.locator(".view-pane")
    expect(views).to_have_count(2)
    expect(views.nth(1).get_by_role("img")).to_have_attribute("alt", re.compile("^/camera at 0:00.500"))
    border = page.get_by_role("separator", name="Border between the columns of views")
    before = centre(border)[0]
    border.press("PageDown")
    until("a wider first view", lambda: centre(border)[0] > before + 20)
    views.nth(1).get_by_label("View 2").select_option("Frames")
    expect(views.nth(1)).to_contain_text("Transforms lead from the sensor’s frame")
    page.keyboard.press("F6")
    until("the focus in a view", lambda: page.evaluate("() => document.activeElement.className") == "view-pane")
    assert violations(page, ".view-stage") == []
    # The address tells it, also of a page that is loaded again.
    until("the address", lambda: "views=beside:map,frames:60:50" in page.url)
    page.reload()
    expect(views.nth(1)).to_contain_text("Transforms lead from the sensor’s frame")
    page.get_by_label("Layout", exact=True).select_option("Map")
    expect(views).to_have_count(1)

    # Two maps beside each other, of which the second is that of a comparison.
    page.get_by_label("Layout", exact=True).select_option("Two maps")
    second = page.get_by_role("region", name="Second map")
    second.get_by_role("button", name="With the present settings").click()
    expect(second.locator(".compare-name")).to_contain_text("saved settings")
    expect(views.first.locator(".compare-name")).to_contain_text("current settings")
    expect(views.first.locator(".compare-divider")).to_have_count(0)
    page.get_by_label("Layout", exact=True).select_option("Map")
    expect(page.locator(".compare-divider")).to_have_count(1)

    # A moment is chosen by its time.
    page.get_by_role("button", name="Go to a time").click()
    field = page.get_by_label("Time to go to")
    field.fill("soon")
    field.press("Enter")
    expect(page.locator(".moment [role=alert]")).to_contain_text("1:13.4")
    field.fill("0:01.0")
    field.press("Enter")
    until("the moment", lambda: abs(frame(page)["stamp"] - 1.0) < 0.051)

    # Each topic leads to its messages, as the recording has them at the moment.
    topics = open_group(page, "Topics")
    topics.get_by_role("button", name="Messages on /imu").click()
    messages = page.get_by_role("tabpanel", name="Messages")
    expect(messages.get_by_label("Topic")).to_have_value("/imu")
    expect(messages.locator(".message-tree").first).to_contain_text("angular_velocity")
    expect(messages).to_contain_text("sensor_msgs/Imu")

    # What nodes logged: the next match is its moment, also of a line that is pressed; the slider marks the grave ones.
    logged = open_group(page, "Log lines")
    rows = logged.locator(".log-line")
    expect(rows).to_have_count(4)
    assert violations(page, ".dock") == []
    logged.get_by_label("Level").select_option(label="warning and above (2)")
    expect(rows).to_have_count(2)
    logged.get_by_label("Search in the lines").press("Enter")
    until("the moment of the next line", lambda: abs(frame(page)["stamp"] - 1.2) < 0.051)
    expect(logged.locator(".log-line[aria-selected=true]")).to_contain_text("Wheel slips")
    logged.get_by_role("listbox", name="Log lines").press("ArrowDown")
    until("the moment of the line below", lambda: abs(frame(page)["stamp"] - 2.1) < 0.051)
    expect(logged.locator(".log-line[aria-selected=true]")).to_contain_text("error")
    logged.get_by_label("Search in the lines").fill("slips")
    rows.first.click()
    until("the moment of a pressed line", lambda: abs(frame(page)["stamp"] - 1.2) < 0.051)

    # Any field is found by a part of its name and plotted, over time and over another one.
    plots = open_group(page, "Plots")
    plots.get_by_role("button", name="Remove (scans) speed").click()  # with which it begins
    field = plots.get_by_label("Add a field to the plot")
    field.fill("imu yaw")
    expect(plots.get_by_role("button", name="/imu orientation.yaw")).to_be_visible()
    field.press("Enter")
    field.fill("odom position.x")
    field.press("Enter")
    legend = plots.get_by_role("list", name="Fields of the plot").get_by_role("listitem")
    expect(legend).to_have_count(2)
    over = plots.locator(".field-plot .u-over")
    expect(over).to_be_visible()
    assert violations(page, ".dock") == []
    over.click()
    until("the middle of the log", lambda: abs(frame(page)["stamp"] - 1.475) < 0.1)
    with page.expect_response(lambda answer: "made=derivative" in answer.url and answer.status == 200) as answered:
        plots.get_by_label("What is shown of /imu orientation.yaw").select_option("derivative")
    assert set(answered.value.json()["columns"][0]["values"][1:]) == {0.2}
    with page.expect_download() as saved:
        plots.get_by_role("button", name="CSV of what is shown").click()
    rows_of_csv = saved.value.path().read_text().splitlines()
    assert rows_of_csv[0] == "time_s,time_utc,d/dt /imu orientation.yaw (rad/s),/odom pose.pose.position.x (m)"
    assert len(rows_of_csv) == 1 + 60
    plots.get_by_label("Horizontal").select_option("/odom pose.pose.position.x")
    expect(plots.locator(".field-plot .u-label").filter(has_text="position.x")).to_have_count(1)

    # What is computed of the log is plotted like a field, and is taken away again.
    field.fill("")
    contradicted = plots.get_by_role("switch", name="contradicted")
    contradicted.click()
    expect(legend).to_have_count(3)
    expect(legend.last.get_by_role("progressbar")).to_have_count(0)
    expect(plots.locator(".field-plot .u-label").filter(has_text="contradicted")).to_have_count(1)
    contradicted.click()
    expect(legend).to_have_count(2)

    # A number of a message leads to its plot.
    messages = open_group(page, "Messages")
    messages.get_by_text("angular_velocity", exact=True).click()
    messages.get_by_role("button", name="plot angular_velocity.z").click()
    expect(legend).to_have_count(3)
    expect(legend.last).to_contain_text("/imu angular_velocity.z")
    expect(plots.locator(".field-plot .u-label").filter(has_text="angular_velocity.z")).to_have_count(1)


@pytest.mark.parametrize("context", ["phone"], indirect=True)
def test_a_layout_begins_at_its_first_view_on_a_phone(page: Page, server: str, tmp_path: Path) -> None:
    opened(page, server, tmp_path)
    page.evaluate("() => gridbloom.connection.store.goTo(20)")
    page.get_by_label("Layout", exact=True).select_option("Moment")
    lines = page.get_by_role("region", name="Log lines", exact=True)
    expect(lines.locator(".log-line[aria-selected=true]")).to_contain_text("Planning")
    frames(page, 3)
    assert page.locator(".view-stage").evaluate("(stage) => stage.scrollLeft") == 0
    # The line of the moment is in sight in its own view.
    page.locator("[data-place='0']").get_by_role("button", name="Go to view 4").tap()
    expect(lines.locator(".log-line[aria-selected=true]")).to_be_in_viewport()


def test_a_place_is_marked_in_the_picture_of_a_camera_and_in_the_plots(page: Page, server: str, tmp_path: Path) -> None:
    focal, bend, (width, height) = 20.0, -0.1, (64, 48)
    info = recorded.camera(T0, (width, height), focal, "/camera_info")
    info.fields["d"][0] = bend
    mount = [  # which is published again and again
        recorded.transform(T0 + at * recorded.SECOND, "base_link", "optical", z=1.0, yaw=-np.pi / 2, roll=-np.pi / 2)
        for at in range(3)
    ]
    opened(page, server, tmp_path, [info, *mount])
    held = map_bytes(page)
    rows, cols = np.nonzero(np.frombuffer(held["bytes"], dtype=np.uint8).reshape(held["rows"], -1) > 150)
    places = np.column_stack([cols, rows]) * held["resolution"] + np.array(held["origin"][:2])
    ahead = places[np.hypot(*(places - (3.0, 0.6)).T).argmin()] + held["resolution"] / 2
    page.keyboard.press("2")
    figure = page.locator(".view-pane").nth(1).locator("figure")
    expect(figure.get_by_role("img")).to_be_visible()
    still(page.locator(".picture"))
    page.keyboard.down("Shift")
    page.mouse.click(*page.evaluate(SCREEN, ahead.tolist()))
    page.keyboard.up("Shift")
    expect(figure).to_contain_text("the selected place, on the floor, is marked")
    # The picture is of 0.5 s, when the robot is 0.5 m along x, and the camera 1 m above the floor.
    x, y = page.evaluate("() => gridbloom.connection.store.explainedPoint.peek()")
    right, down = -y / (x - 0.5), 1.0 / (x - 0.5)
    bent = 1.0 + bend * (right**2 + down**2)
    circle = figure.locator("circle")
    wanted = (width / 2 + focal * right * bent, height / 2 + focal * down * bent)
    assert np.allclose([float(circle.get_attribute(name) or 0) for name in ("cx", "cy")], wanted, atol=0.01)

    # The beam that updated the cell last is marked in the plots at its time.
    page.get_by_role("button", name="Plots", exact=True).click()
    expect(page.locator("[data-strip=speed] .u-over")).to_be_visible()
    slider = page.get_by_role("slider", name="Moment in the plots")
    first, last = (float(slider.get_attribute(f"aria-value{end}") or 0) for end in ("min", "max"))
    await_true(page, "() => gridbloom.connection.store.selectedContribution.peek() !== null")
    stamp = page.evaluate("() => gridbloom.connection.store.selectedContribution.peek().stamp")
    share = (stamp - first) / (last - first)
    until("a line at the time", lambda: np.allclose(page.evaluate(MARKED), [share], atol=0.01))
    page.evaluate("() => gridbloom.connection.store.explain(null)")
    until("no line", lambda: page.evaluate(MARKED) == [])


#: Layouts, and what the second and the third of their views have when their contents are there.
VIEWS = {
    "four:picture,messages,lines,plots:50:50": ("frame_id", "Wheel slips"),
    "four:3d,residuals,frames,second:50:50": ("contradicts", "Transforms lead"),
}


@pytest.mark.parametrize(("context", "scheme"), [LOOKS[0], *also_long_rows(LOOKS[1])], indirect=["context"])
def test_axe_finds_nothing_in_views_for_their_owner_and_a_guest_and_in_the_report(
    page: Page, visitor: BrowserContext, server: str, tmp_path: Path, scheme: Literal["light", "dark"]
) -> None:
    page.emulate_media(color_scheme=scheme)
    without_canvas_in_3d(page)
    opened(page, server, tmp_path)
    hello = page.evaluate("() => gridbloom.connection.store.hello.peek()")
    shared = open_group(page, "Share")
    shared.get_by_role("button", name="Create link").click()
    link = shared.get_by_role("listitem").get_by_role("textbox").input_value()
    guest = visitor.new_page()
    for layout, contents in VIEWS.items():
        for where, address in (
            (page, f"{server}/logs.html?log={hello['log']['id']}&views={layout}"),
            (guest, f"{link}?views={layout}"),
        ):
            where.goto(address)
            await_map(where)
            views = where.locator(".view-pane")
            expect(views).to_have_count(4)
            for n, words in enumerate(contents):
                expect(views.nth(n + 1)).to_contain_text(words)
            assert violations(where, ".viewer") == []
    page.goto(f"{server}/api/sessions/{hello['session']}/report")
    expect(page.get_by_role("main")).to_contain_text("Versions")
    assert violations(page) == []


def test_a_distance_is_measured_from_wall_to_wall(page: Page, server: str) -> None:
    open_sample(page, server)
    await_map(page)
    page.evaluate("() => gridbloom.connection.store.send({ type: 'pause' })")
    until("the log to stand", lambda: not frame(page)["playing"])
    # The two occupied cells of one row that are farthest apart: the walls to the left and the right of the robot.
    row = page.evaluate("""() => {
      const { geometry, cells } = gridbloom.connection.store.map.peek();
      let best = null;
      for (let row = 0; row < geometry.rows; row++) {
        const cols = [];
        for (let col = 0; col < geometry.cols; col++) if (cells.at(row, col) > 150) cols.push(col);
        if (cols.length > 1 && (!best || cols.at(-1) - cols[0] > best[2] - best[1])) best = [row, cols[0], cols.at(-1)];
      }
      const at = (col) => [0, 1].map((k) => geometry.origin[k] + ([col, best[0]][k] + 0.5) * geometry.resolution);
      return best && { from: at(best[1]), to: at(best[2]), resolution: geometry.resolution };
    }""")
    assert row is not None
    page.get_by_role("toolbar", name="Map tools").get_by_role("button", name="Measure a distance").click()
    measured = page.get_by_role("region", name="Measured")
    expect(measured).to_contain_text("two sides of a door")
    for point in (row["from"], row["to"]):
        x, y = page.evaluate(SCREEN, point)
        page.mouse.click(x, y)
    expect(measured).to_contain_text(f"± {row['resolution']:.2f} m")
    distance = float(re.search(r"([\d.]+) m ±", measured.inner_text())[1])  # type: ignore[index]
    assert abs(distance - abs(row["to"][0] - row["from"][0])) <= 2.0 * row["resolution"]
    # Where the map is one of four views it is not hidden by what is measured.
    page.set_viewport_size({"width": 1024, "height": 700})
    page.keyboard.press("4")
    expect(page.locator(".view-pane")).to_have_count(4)

    def covered() -> float:
        boxes = [one.bounding_box() or {"width": 0.0, "height": 0.0} for one in (measured, page.locator(".viewer-map"))]
        own, whole = (box["width"] * box["height"] for box in boxes)
        return own / whole

    until("most of the map to be seen", lambda: 0.0 < covered() < 0.3)
    page.locator(".picture").press("Escape")
    expect(measured).to_contain_text("two sides of a door")
    page.locator(".picture").press("Escape")
    expect(measured).to_have_count(0)
