"""A costmap over a log's map, in Chromium: a goal is clicked and dragged, the yaml is taken away."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Page, expect

from tests.browser.looking import await_true, drag_along, open_group, open_sample, place_on

_STORE = "gridbloom.connection.store"
_PATH = f"{_STORE}.part('path').message.peek()"


def place(page: Page, x: float, y: float) -> tuple[float, float]:
    """Return the place on the page of a point of the map."""
    return place_on(page.locator(".viewer .picture"), (x, y))


def terrain_files(folder: Path) -> list[Path]:
    """The map of a terrain around the origin, 40 m wide: unsafe where x is above 0."""
    pixels = np.full((80, 80), 254, np.uint8)
    pixels[:, 40:] = 0
    Image.fromarray(pixels).save(folder / "slopes.pgm")
    (folder / "slopes.yaml").write_text(
        "image: slopes.pgm\nresolution: 0.5\norigin: [-20, -20, 0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    return [folder / "slopes.pgm", folder / "slopes.yaml"]


def test_the_terrain_of_a_map_is_a_sheet_of_the_costmap(page: Page, server: str, tmp_path: Path) -> None:
    page.goto(f"{server}/logs.html")
    page.set_input_files("input[type=file]", terrain_files(tmp_path))
    await_true(page, "() => window.gridbloom && gridbloom.connection.store.map.peek()?.geometry.rows === 80")
    page.get_by_role("button", name="All logs").click()
    page.locator(".log-card", has_text="sample").get_by_role("button", name="Open map").click()
    open_group(page, "Costmap")
    await_true(page, f"() => window.gridbloom && {_STORE}.part('costmap').message.peek()?.is_on")
    sheet = page.get_by_role("switch", name="Terrain", exact=True)
    assert sheet.count() == 0
    page.locator("select", has_text="slopes.yaml (map)").select_option(label="slopes.yaml (map)")
    expect(sheet).to_have_attribute("aria-checked", "true")
    unsafe = "(() => { const m = gridbloom.connection.store.layers.grid('terrain_layer').map.peek(); if (!m) return 0;"
    unsafe += " let n = 0; for (let r = 0; r < m.geometry.rows; r++) for (let c = 0; c < m.geometry.cols; c++)"
    unsafe += " if (m.cells.at(r, c) === 255) n++; return n; })()"
    await_true(page, f"() => {unsafe} > 1000")
    page.get_by_role("button", name="Without terrain").click()
    expect(sheet).to_have_count(0)


def test_a_path_on_a_log(page: Page, server: str, tmp_path: Path) -> None:
    open_sample(page, server)
    open_group(page, "Path")
    await_true(page, f"() => window.gridbloom && {_STORE}.part('costmap').message.peek()?.is_on")
    await_true(page, "() => { const f = gridbloom.connection.store.frame.peek(); return f?.index === f?.count; }")
    # Nothing of a simulation: nobody drives a log's robot, and there are no scenes.
    assert page.get_by_role("button", name="Put a table in the way").count() == 0
    poses = page.evaluate("() => gridbloom.connection.store.trajectory.peek().poses")
    first, second = poses[len(poses) // 2], poses[len(poses) // 4]
    page.mouse.click(*place(page, *first))
    await_true(page, f"() => {_PATH}?.reaches_goal")
    assert page.get_by_role("button", name="Drive there").count() == 0
    drag_along(page, place(page, *first), place(page, *second))
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
    expect(page.get_by_text("The map’s value is")).to_be_visible()
    open_group(page, "Costmap")
    with page.expect_download() as download:
        page.get_by_role("button", name="Download yaml").click()
    download.value.save_as(tmp_path / "nav2.yaml")
    text = (tmp_path / "nav2.yaml").read_text()
    (tmp_path / "other.yaml").write_text(text.replace("cost_scaling_factor: 3.0", "cost_scaling_factor: 5.0"))
    assert "cost_scaling_factor: 3.0" in text
    page.get_by_label("Nav2 parameter file").set_input_files(tmp_path / "other.yaml")
    await_true(page, f"() => {_STORE}.part('costmap').message.peek().values.cost_scaling_factor === 5")
