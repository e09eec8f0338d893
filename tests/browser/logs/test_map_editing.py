"""A map in the editor, in Chromium: painted, marked, undone, cropped, saved; its files by another reader."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import yaml
from PIL import Image
from playwright.sync_api import Page, expect

from tests.browser.logs.test_log_path import place
from tests.browser.looking import await_true, drag_along, open_group, until

_STORE = "gridbloom.connection.store"
_EDITS = f"{_STORE}.part('map_edits').message.peek()"
RESOLUTION, ROWS, COLS = 0.1, 60, 90


def written(folder: Path) -> list[Path]:
    """Write a map of free cells with a wall around it and a speck, as map_saver does."""
    pixels = np.full((ROWS, COLS), 254, np.uint8)
    pixels[[0, -1]] = pixels[:, [0, -1]] = 0
    pixels[20, 70] = 0
    Image.fromarray(pixels).save(folder / "room.pgm")
    about = (
        "image: room.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    (folder / "room.yaml").write_text(about)
    return [folder / "room.pgm", folder / "room.yaml"]


def edited(page: Page, n: int) -> None:
    """Wait until the page has ``n`` edits, and the map after them."""
    await_true(page, f"(n) => {_EDITS}?.n === n", arg=n)


def state(page: Page, x: float, y: float) -> str:
    """Return what the page says of a cell."""
    page.evaluate(f"(point) => {{ {_STORE}.pinned.value = point; }}", [x, y])
    return str(page.locator("[data-state]").get_attribute("data-state"))


def test_an_edited_map_is_measured(page: Page, server: str, tmp_path: Path) -> None:
    page.goto(f"{server}/logs.html")
    page.set_input_files("input[type=file]", written(tmp_path))
    await_true(page, f"() => window.gridbloom && {_EDITS} && {_STORE}.map.peek()")
    tools = page.get_by_role("toolbar", name="Map tools")
    tools.get_by_role("button", name="Measure a distance").click()
    expect(page.get_by_role("radio", name="Move", exact=True)).to_be_checked()  # the brush is put away
    for at in ((0.12, 3.05), (8.88, 3.02)):
        page.mouse.click(*place(page, *at))
    measured = page.get_by_role("region", name="Measured")
    # From the middle of one wall's cell to that of the other: cells 0 and 89 of 0.1 m.
    expect(measured).to_contain_text("8.90 m ± 0.10 m")
    page.mouse.move(*place(page, 2.0, 3.0))
    expect(page.locator(".map-point")).to_contain_text(re.compile(r"x (1\.9|2\.0)\d  y (2\.9|3\.0)\d m"))
    page.get_by_role("radio", name="Line", exact=True).check(force=True)
    expect(measured).to_have_count(0)
    drag_along(page, *(place(page, *one) for one in ((2.0, 3.05), (6.0, 3.05))))
    edited(page, 1)


def taken(page: Page, button: str, folder: Path) -> Path:
    """Take a file away."""
    with page.expect_download() as download:
        page.get_by_role("link", name=button, exact=True).click()
    path = folder / download.value.suggested_filename
    download.value.save_as(path)
    return path


def test_a_map_is_edited_and_kept(page: Page, server: str, tmp_path: Path) -> None:
    page.goto(f"{server}/logs.html")
    page.set_input_files("input[type=file]", written(tmp_path))
    await_true(page, f"() => window.gridbloom && {_EDITS} && {_STORE}.map.peek()")

    def use(tool: str, *places: tuple[float, float]) -> None:
        page.get_by_role("radio", name=tool, exact=True).check(force=True)
        drag_along(page, *(place(page, *one) for one in places))

    assert state(page, 4.05, 3.05) == "free"
    use("Brush", (2.0, 3.05), (4.0, 3.05), (6.0, 3.05))
    edited(page, 1)
    until("the wall", lambda: state(page, 4.05, 3.05) == "occupied")
    use("Keepout", (1.0, 1.0), (3.0, 2.0))
    edited(page, 2)
    until("the zone", lambda: state(page, 2.05, 1.55) == "free, keepout")
    page.get_by_role("radio", name="Speed", exact=True).check(force=True)
    limit = page.get_by_label("Limit, as a number")
    limit.fill("30")
    limit.press("Enter")
    drag_along(page, *(place(page, *one) for one in ((3.0, 4.0), (4.0, 4.8))))
    edited(page, 3)
    until("the speed limit", lambda: state(page, 3.55, 4.45) == "free, speed 30 %")
    page.keyboard.press("Control+z")
    edited(page, 2)
    until("no speed limit", lambda: state(page, 3.55, 4.45) == "free")
    page.get_by_role("button", name="Redo").click()
    edited(page, 3)
    page.keyboard.press("Control+z")
    edited(page, 2)
    page.keyboard.press("Control+z")
    edited(page, 1)
    until("no zone", lambda: state(page, 2.05, 1.55) == "free")
    page.get_by_role("button", name="Redo").click()
    edited(page, 2)
    # With the keyboard: a line between two cells.
    page.get_by_role("radio", name="Line", exact=True).check(force=True)
    page.get_by_role("radio", name="Unknown").check(force=True)
    page.locator(".viewer .picture").focus()
    for point in ([7.05, 1.05], [8.05, 1.05]):
        page.evaluate(f"(point) => {{ {_STORE}.pinned.value = point; }}", point)
        page.keyboard.press("Enter")
    edited(page, 3)
    until("unknown cells", lambda: state(page, 7.55, 1.05) == "unknown")
    page.get_by_role("button", name="Remove specks").click()
    edited(page, 4)
    until("no speck", lambda: state(page, 7.05, 3.95) == "free")
    use("Crop", (0.55, 0.55), (8.95, 4.45))
    edited(page, 5)
    await_true(page, f"() => {_STORE}.map.peek().geometry.rows === 40")
    use("Origin", (1.0, 1.0), (1.0, 2.0))
    edited(page, 6)
    open_group(page, "Save")
    files = [taken(page, name, tmp_path) for name in ("pgm", "yaml", "Keepout pgm", "Keepout yaml", "Edits")]
    about = yaml.safe_load(files[1].read_text())
    assert about["image"] == files[0].name
    # The corner of the cropped map, (0.5, 0.5), is half a metre left of and behind the new origin, which looks up.
    np.testing.assert_allclose(about["origin"], [-0.5, 0.5, -np.pi / 2], atol=0.02)
    pixels = np.asarray(Image.open(files[0]))[::-1]
    assert pixels.shape == (40, 85)
    assert (pixels[25, 20], pixels[10, 10], pixels[5, 70]) == (0, 254, 205)
    mask = np.asarray(Image.open(files[2]))[::-1]
    assert mask[10, 15] > 0 == mask[20, 15]
    edits = json.loads(files[4].read_text())["edits"]
    assert [one["op"] for one in edits] == ["paint", "keepout", "paint", "despeckle", "crop", "origin"]

    page.get_by_role("textbox", name="Name").fill("A better room")
    page.get_by_role("button", name="Save", exact=True).click()
    page.get_by_role("link", name="Open it").click()
    await_true(page, f"() => window.gridbloom && {_EDITS}?.n === 0 && {_STORE}.map.peek()?.geometry.rows === 40")
    expect(page).to_have_title(re.compile("^A better room"))
    expect(page.get_by_text("Made by 6 edits of 'room.yaml'.")).to_be_visible()
    page.get_by_role("button", name="All logs").click()
    card = page.locator(".log-card", has_text="A better room")
    expect(card.get_by_text("8.5 m × 4.0 m")).to_be_visible()
    # A log can be localized in it.
    page.locator(".log-card", has_text="sample").get_by_role("button", name="Open map").click()
    open_group(page, "Localize")
    page.get_by_text("Another log or map").click()
    page.get_by_label("The other log").select_option(label="A better room (map)")
    expect(page.locator(".panel-stack").get_by_text("8.5 × 4.0 m")).to_be_visible()
    # And its costmap lies over it, with the zone.
    open_group(page, "Costmap")
    costs = f"{_STORE}.layers.grid('costmap').map.peek()"
    await_true(page, f"() => {costs}")
    page.evaluate(f"() => {_STORE}.setPart('costmap', {{ map: 'given', obstacle_layer: false, dynamic_layer: false }})")
    await_true(page, f"() => {costs}?.geometry.rows === 40 && {costs}.cells.at(10, 15) === 255")
    assert taken(page, "pgm", tmp_path).read_bytes().startswith(b"P5\n85 40\n255\n")
