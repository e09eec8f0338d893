"""Sensors of a recording on the log page: several in one map, clouds that are cut, a late one that the doctor mends."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Locator, Page, expect

from mapper.io.export import write_mcap
from mapper.sensors.joint_log import SEPARATOR, JointLog
from mapper.simulation.lidar import SensorConfig
from tests.browser.looking import SECONDS, await_true, drag_along, frame, open_group, settled_digest, until
from tests.mapper.io.contents.recorded_robot import T0, imu
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recording.test_clouds import recording_of_room
from tests.mapper.mapping.sweeping import swept
from tests.mapper.slam.worlds import along, drive

LOG = "() => window.gridbloom && gridbloom.connection.store.hello.value?.log"
OPEN = f"() => ({LOG})() && gridbloom.connection.store.frame.peek()"


def opened(page: Page, server: str, path: Path, button: str | None = None) -> None:
    page.goto(f"{server}/logs.html")
    page.set_input_files("input[type=file]", path)
    await_true(page, OPEN)  # a single log opens by itself once it is read
    if button is not None:
        page.goto(f"{server}/logs.html")
        card = page.locator(".log-card", has_text=path.name)
        card.get_by_text("Contents").click()
        card.get_by_role("button", name=button).click()
        await_true(page, OPEN)


def two_lidars() -> list[recorded.Said]:
    """A robot in the middle of a cell, with a lidar that sees a wall 2 m ahead, and one that sees one 1 m astern."""
    said = [
        recorded.transform(T0, "base_link", "ahead", 0.3, topic="/tf_static"),
        recorded.transform(T0, "base_link", "astern", -0.3, yaw=np.pi, topic="/tf_static"),
    ]
    for step in range(20):
        at = T0 + step * recorded.SECOND // 10
        said.append(recorded.transform(at, "odom", "base_link", 1.02, 2.02))
        said.append(recorded.scan(at, np.full(30, 2.0), "/scan_ahead", "ahead"))
        said.append(recorded.scan(at + recorded.SECOND // 20, np.full(30, 1.0), "/scan_astern", "astern"))
    return said


def state_at(page: Page, x: float, y: float) -> str:
    """Return what the settled map of the page says of the cell at a point."""
    settled_digest(page)
    page.evaluate(
        """(point) => {
          gridbloom.connection.store.inspected.value = null;
          gridbloom.connection.store.pinned.value = null;
          gridbloom.connection.store.pinned.value = point;
        }""",
        [x, y],
    )
    found = until(
        "the cell",
        lambda: page.evaluate(
            """([x, y]) => {
              const cell = gridbloom.connection.store.inspected.value;
              if (gridbloom.connection.store.cell.value === null) return "unknown"; // outside the grid
              return cell && Math.hypot(cell.x - x, cell.y - y) < 0.1 ? cell.state : null;
            }""",
            [x, y],
        ),
    )
    return str(found)


def explained(page: Page, x: float, y: float) -> Locator:
    page.evaluate("(point) => gridbloom.connection.store.explain(point)", [x, y])
    return page.get_by_role("tabpanel", name="Why")


def test_two_lidars_make_one_map_and_why_names_the_sensor(page: Page, server: str, tmp_path: Path) -> None:
    (tmp_path / "two.mcap").write_bytes(recorded.mcap_bytes(two_lidars()))
    opened(page, server, tmp_path / "two.mcap", "Map 2 lidars together")
    until("the whole log", lambda: frame(page)["index"] == 40)
    assert page.evaluate(LOG)["topic"] == SEPARATOR.join(("/scan_ahead", "/scan_astern"))
    ahead, astern = (1.02 + 0.3 + 2.0, 2.02), (1.02 - 0.3 - 1.0, 2.02)
    assert (state_at(page, *ahead), state_at(page, *astern)) == ("occupied", "occupied")
    assert state_at(page, 2.02, 2.02) == "free"
    expect(explained(page, *ahead)).to_contain_text("/scan_ahead")
    why = explained(page, *astern)
    expect(why).to_contain_text("/scan_astern")
    expect(why).not_to_contain_text("/scan_ahead")
    # One of them by itself, in the same session: what the other one saw is unknown then.
    open_group(page, "Topics")
    page.get_by_role("button", name="Map /scan_ahead").click()
    until("one sensor", lambda: page.evaluate(LOG)["topic"] == "/scan_ahead" and frame(page)["index"] == 20)
    assert (state_at(page, *ahead), state_at(page, *astern)) == ("occupied", "unknown")
    page.get_by_role("button", name="Map 2 lidars together").click()
    until("both again", lambda: frame(page)["index"] == 40)


def test_the_cut_of_a_cloud_is_changed_and_its_map_shown(page: Page, server: str, tmp_path: Path) -> None:
    (tmp_path / "room.mcap").write_bytes(recorded.mcap_bytes(recording_of_room(n=6)))
    opened(page, server, tmp_path / "room.mcap")
    until("the whole log", lambda: frame(page)["index"] == 6)
    assert page.evaluate(LOG)["n_beams"] == 360
    ahead, behind = (1.52, 0.02), (-1.48, 0.02)
    settings = open_group(page, "Settings")
    cut = settings.get_by_role("button", name="Cut the scans again")
    expect(cut).to_be_disabled()
    # Points of the floor and of the ceiling end beams near the robot.
    assert state_at(page, *behind) == "unknown"
    settings.get_by_label("Minimum height").fill("0,3")
    settings.get_by_label("Maximum height").fill("2")
    cut.click()
    until("the walls", lambda: page.evaluate(LOG)["cut"]["values"]["min_height"] == 0.3 and frame(page)["index"] == 6)
    assert (state_at(page, *ahead), state_at(page, *behind)) == ("free", "free")
    settings.get_by_label("First bearing").fill("−45")
    settings.get_by_label("Last bearing").fill("45")
    cut.click()
    until("the other cut", lambda: page.evaluate(LOG)["n_beams"] == 90 and frame(page)["index"] == 6)
    expect(settings.get_by_label("First bearing")).to_have_value("−45.00")
    # Behind the robot nothing is seen any more.
    assert (state_at(page, *ahead), state_at(page, *behind)) == ("free", "unknown")
    settings.get_by_label("Maximum height").fill("0.2")
    expect(settings).to_contain_text("The lowest height must be below the greatest.")
    expect(cut).to_be_disabled()


@pytest.mark.long
def test_a_delay_is_mended_by_its_own_button(page: Page, server: str, tmp_path: Path) -> None:
    with (tmp_path / "late.mcap").open("wb") as file:
        write_mcap(file, swept(60, delay=0.2))
    opened(page, server, tmp_path / "late.mcap")
    doctor = open_group(page, "Overview")
    finding = doctor.locator('[data-check="timing.delay"]')
    finding.get_by_role("button", name="Apply to the map").click()
    expect(finding.get_by_role("button", name="Applied to the map")).to_be_disabled()
    offset = page.evaluate("() => gridbloom.connection.store.mapping.values.value.time_offset")
    assert abs(abs(offset) - 0.2) < 0.06
    until("the map", lambda: "remade_ms" in frame(page))


def test_a_plot_is_zoomed_into_finer_values(page: Page, server: str, tmp_path: Path) -> None:
    rate = 1000
    said = [imu(T0 + n * recorded.SECOND // rate, float(np.sin(n)), 0.0, 0.0) for n in range(4 * rate)]
    said += [recorded.scan(T0 + n * recorded.SECOND, [1.0, 2.0]) for n in range(4)]
    (tmp_path / "fast.mcap").write_bytes(recorded.mcap_bytes(said))
    opened(page, server, tmp_path / "fast.mcap")
    plots = open_group(page, "Plots")
    expect(plots).to_contain_text("Of the 4,000 values in the log the least and the greatest")
    expect(plots.get_by_role("switch").first).to_be_visible()  # above the plot, once the fields are known
    over = plots.locator('[data-plot="angular velocity"] .u-over')
    box = over.bounding_box()
    assert box is not None
    x, y = box["x"], box["y"] + 0.5 * box["height"]
    with page.expect_response(lambda answer: "start=" in answer.url) as answered:
        drag_along(page, (x + 0.50 * box["width"], y), (x + 0.60 * box["width"], y), steps=4)
    found = answered.value.json()
    # A tenth of the values, which are few enough to be sent as they are: one for each millisecond.
    assert 350 < found["samples"] < 450
    assert len(found["times"]) == found["samples"]
    assert abs(float(np.median(np.diff(found["times"]))) - 0.001) < 1e-5
    expect(plots).not_to_contain_text("the least and the greatest")
    plots.get_by_role("button", name="Show the whole log").click()
    expect(plots).to_contain_text("Of the 4,000 values in the log")


@pytest.mark.long
def test_two_lidars_of_one_log_are_healed_together(page: Page, server: str, tmp_path: Path) -> None:
    path = along([(1.2, 1.5), (4.6, 1.5), (4.6, 3.4), (1.2, 3.4), (1.2, 1.5)], 0.25)
    ahead = SensorConfig(n_beams=120, field_of_view=np.pi, range_max=8.0, range_noise=0.01)
    front, back = (
        replace(drive("room", path, sensor=ahead, mount=mount, turn_bias=0.1), topic=topic)
        for topic, mount in (("/front", (0.2, 0.0, 0.0)), ("/back", (-0.2, 0.0, np.pi)))
    )
    odometry = {"odometry": front.trajectories["odometry"]}
    later = replace(back, trajectories=odometry, stamps_ns=back.stamps_ns + 1_000_000)
    with (tmp_path / "both.mcap").open("wb") as file:
        write_mcap(file, JointLog.of([replace(front, trajectories=odometry), later]))
    opened(page, server, tmp_path / "both.mcap", "Map 2 lidars together")
    until("the whole log", lambda: frame(page)["index"] == 2 * len(path))
    heal = open_group(page, "Heal")
    heal.get_by_role("button", name="Heal its poses").click()
    panel = page.get_by_role("region", name="Heal its poses")
    expect(panel).to_contain_text("Healed", timeout=5 * SECONDS * 1000)
    cell = panel.locator("dd[data-figure=sharpness]")
    before, after = (float(str(cell.get_attribute(name))) for name in ("data-before", "data-after"))
    assert before < after
    until("both sensors", lambda: frame(page)["index"] == 2 * len(path))
    assert page.evaluate(LOG)["topic"] == SEPARATOR.join(("/front", "/back"))
    # A step of the graph is from a scan of the one lidar to the next of the other; each is drawn where it looks.
    session = page.evaluate("() => gridbloom.connection.store.hello.value.session")
    edge = page.request.get(f"{server}/api/sessions/{session}/graph/edges/4").json()
    assert edge["scans"] == [4, 5]
    (x, _, yaw), _ = edge["poses"]
    for name, side in (("i", 1.0), ("aligned", -1.0)):
        along_robot = np.array(edge["points"][name])[:, 0] - x
        assert abs(yaw) < 0.1
        assert side * np.median(along_robot) > 0.0


def test_a_sensor_opens_with_the_transforms_of_another_topic_by_keyboard_and_mouse(
    page: Page, server: str, tmp_path: Path
) -> None:
    said = two_lidars()[:2]
    for step in range(20):
        at = T0 + step * recorded.SECOND // 10
        said.append(recorded.transform(at, "odom", "base_link", 1.02, 2.02))
        said.append(recorded.transform(at, "world", "base_link", 5.02, 2.02, topic="/tf_gt"))
        said.append(recorded.scan(at, np.full(30, 2.0), "/scan_ahead", "ahead"))
    path = recorded.written(tmp_path, said, "mcap")
    opened(page, server, path)
    page.goto(f"{server}/logs.html")
    card = page.locator(".log-card", has_text=path.name)
    card.locator("summary", has_text="Contents").focus()
    page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    by_transforms = card.get_by_role("button", name="Open with the transforms of /tf_gt", exact=True)
    expect(by_transforms).to_be_focused()
    page.keyboard.press("Enter")
    await_true(page, OPEN)
    assert page.evaluate(LOG)["topic"] == "/scan_ahead#/tf_gt"

    page.goto(f"{server}/logs.html")
    card.locator("summary", has_text="Contents").click()
    by_transforms.click()
    await_true(page, OPEN)
    assert page.evaluate(LOG)["topic"] == "/scan_ahead#/tf_gt"
