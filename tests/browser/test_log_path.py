"""A costmap over a log's map, in Chromium: a goal is clicked and dragged, the yaml is taken away."""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import Page, expect

from tests.browser.looking import await_true, open_group

_NAVIGATION = "gridbloom.connection.store.navigation"
_PATH = f"{_NAVIGATION}.path.peek()"


def place(page: Page, x: float, y: float) -> tuple[float, float]:
    """Return the place on the page of a point of the map."""
    box = page.locator(".viewer .picture").bounding_box()
    assert box is not None
    px, py = page.evaluate("(xy) => gridbloom.screen(xy)", [x, y])
    return box["x"] + px, box["y"] + py


def drag(page: Page, *places: tuple[float, float]) -> None:
    page.mouse.move(*places[0])
    page.mouse.down()
    for one in places[1:]:
        page.mouse.move(*one, steps=3)
    page.mouse.up()


def test_a_path_on_a_log(page: Page, server: str, tmp_path: Path) -> None:
    page.emulate_media(reduced_motion="reduce")  # the log stands at its end
    page.goto(f"{server}/logs.html")
    page.locator(".log-card", has_text="sample").get_by_role("button", name="Open map").click()
    open_group(page, "Path")
    await_true(page, f"() => window.gridbloom && {_NAVIGATION}.costmap.peek()?.is_on")
    await_true(page, "() => { const f = gridbloom.connection.store.frame.peek(); return f?.index === f?.count; }")
    # Nothing of a simulation: nobody drives a log's robot, and there are no scenes.
    assert page.get_by_role("button", name="Put a table in the way").count() == 0
    poses = page.evaluate("() => gridbloom.connection.store.trajectory.peek().poses")
    first, second = poses[len(poses) // 2], poses[len(poses) // 4]
    page.mouse.click(*place(page, *first))
    await_true(page, f"() => {_PATH}?.reaches_goal")
    assert page.get_by_role("button", name="Drive there").count() == 0
    drag(page, place(page, *first), place(page, *second))
    await_true(
        page,
        f"(to) => {{ const g = {_PATH}?.goal; return g && Math.hypot(g[0] - to[0], g[1] - to[1]) < 0.3; }}",
        arg=second,
    )
    before = page.evaluate(f"() => {_PATH}.length")
    # Seeking moves the robot, and with it the beginning of the path.
    page.evaluate(f"() => gridbloom.connection.store.send({{ type: 'seek', index: {len(poses) // 3} }})")
    await_true(page, f"() => Math.abs({_PATH}.length - {before}) > 0.3")
    page.get_by_role("radio", name="Why").check()
    page.mouse.click(*place(page, *first))
    expect(page.get_by_text("The map's value is")).to_be_visible()
    open_group(page, "Costmap")
    with page.expect_download() as download:
        page.get_by_role("button", name="Download yaml").click()
    download.value.save_as(tmp_path / "nav2.yaml")
    text = (tmp_path / "nav2.yaml").read_text()
    (tmp_path / "other.yaml").write_text(text.replace("cost_scaling_factor: 3.0", "cost_scaling_factor: 5.0"))
    assert "cost_scaling_factor: 3.0" in text
    page.get_by_label("Nav2 parameter file").set_input_files(tmp_path / "other.yaml")
    await_true(page, f"() => {_NAVIGATION}.costmap.peek().values.cost_scaling_factor === 5")
