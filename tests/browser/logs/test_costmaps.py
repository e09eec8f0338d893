"""Recorded costmaps on the logs page: played back, cell for cell as an independent reader has them."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from playwright.sync_api import BrowserContext, Page, expect

from mapper.grid import GridGeometry
from mapper.io.costmaps import RecordedCostmap, write_costmaps
from tests.browser.logs.test_log_path import place
from tests.browser.looking import await_true, frame, map_bytes, open_group, until
from tests.browser.pages.test_axe import violations
from tests.browser.visits import WatchedPage

OPEN = "() => window.gridbloom && gridbloom.connection.store.frame.peek() && gridbloom.connection.store.map.peek()"
COUNT = 231


def costs_of(path: Path) -> np.ndarray:
    """Return the costs (messages, rows, cols) of a recording, by mcap-ros2-support."""
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        messages = reader.iter_decoded_messages(topics=["/local_costmap/costmap", "/costmap_raw"])
        return np.array(
            [
                np.frombuffer(bytes(message.data), np.uint8).reshape(message.metadata.size_y, message.metadata.size_x)
                for _, _, _, message in messages
            ]
        )


def shown(page: Page, rows: int, cols: int) -> np.ndarray:
    """Return the costs that the page has: a byte 0 is no information, 1 … 255 are 0 … 254."""
    found = page.evaluate(
        """([rows, cols]) => {
          const { cells } = gridbloom.connection.store.map.peek();
          return Array.from({ length: rows * cols }, (_, k) => cells.at(Math.floor(k / cols), k % cols));
        }""",
        [rows, cols],
    )
    found = np.array(found)
    return np.where(found == 0, 255, found - 1).reshape(rows, cols).astype(np.uint8)


def seek(page: Page, index: int) -> None:
    page.evaluate(f"() => gridbloom.connection.store.send({{ type: 'seek', index: {index} }})")
    until("the costmap is shown", lambda: frame(page)["index"] == index)


def test_a_recording_of_nav2_is_shown_cell_for_cell(page: Page, server: str, data_file: Callable[[str], Path]) -> None:
    path = data_file("bags/cm_moving_obstacle_0.mcap")
    expected = costs_of(path)
    page.goto(f"{server}/logs.html")
    page.set_input_files("input[type=file]", path)
    await_true(page, OPEN)
    assert frame(page)["count"] == COUNT == len(expected)
    different = np.flatnonzero(np.any(expected[1:] != expected[:-1], axis=(1, 2))) + 1
    for k in (0, *different[:3].tolist(), COUNT - 1):
        seek(page, k + 1)
        until(f"costmap {k}", lambda k=k: np.array_equal(shown(page, 100, 100), expected[k]))  # type: ignore[misc]
    lethal = next(k for k in range(COUNT) if (expected[k] == 254).any())
    seek(page, lethal + 1)
    row, col = (int(v) for v in np.argwhere(expected[lethal] == 254)[0])
    point = [-2.475 + 0.05 * col, -2.475 + 0.05 * row]
    page.evaluate("(point) => { gridbloom.connection.store.pinned.value = point; }", point)
    expect(page.locator("[data-cost]")).to_have_attribute("data-cost", "254")
    expect(page.locator(".readout").get_by_text("lethal", exact=True)).to_be_visible()
    page.get_by_role("button", name="Forward one costmap").click()
    until("the next costmap", lambda: frame(page)["index"] == lethal + 2)
    seek(page, COUNT - 1)
    page.get_by_role("button", name="Play", exact=True).click()
    until("the end", lambda: frame(page)["index"] == COUNT and not frame(page)["playing"])


def test_costs_of_each_value_and_windows_that_move(page: Page, server: str, tmp_path: Path) -> None:
    """Every cost 0 … 255, and a second costmap of another size and place."""
    first = np.arange(256, dtype=np.uint8).reshape(8, 32)
    second = np.full((70, 65), 100, np.uint8)
    stamps = (10**9, 2 * 10**9)
    geometries = (GridGeometry(0.1, 8, 32, (1.0, 2.0, 0.0)), GridGeometry(0.1, 70, 65, (3.0, 2.0, 0.0)))
    with (tmp_path / "two.mcap").open("wb") as file:
        made = zip(stamps, geometries, (first, second), strict=True)
        write_costmaps(file, [RecordedCostmap(t, t, "odom", "master", where, costs) for t, where, costs in made])
    page.goto(f"{server}/logs.html")
    page.set_input_files("input[type=file]", tmp_path / "two.mcap")
    await_true(page, OPEN)
    until("all costs", lambda: np.array_equal(shown(page, 8, 32), first))
    page.get_by_role("toolbar", name="Map tools").get_by_role("button", name="Measure a distance").click()
    for at in ((2.0, 2.75), (3.97, 2.75)):  # the one lethal cell begins at x = 4.0 m; beside it is an inscribed one
        page.mouse.click(*place(page, *at))
    text = page.get_by_role("region", name="Measured").locator(".number").inner_text()
    assert float(re.findall(r"(\d\.\d\d) m ± 0\.10 m", text)[0]) == pytest.approx(2.0, abs=0.015)
    page.get_by_role("button", name="Close the ruler").click()
    seek(page, 2)
    until("the second", lambda: map_bytes(page)["cols"] == 65)
    until("its costs", lambda: np.array_equal(shown(page, 70, 65), second))


def test_a_link_opens_this_costmap_for_a_guest_until_it_is_revoked(
    page: Page, visitor: BrowserContext, server: str, tmp_path: Path
) -> None:
    nine_costmaps(tmp_path / "nine.mcap")
    page.goto(f"{server}/logs.html")
    page.set_input_files("input[type=file]", tmp_path / "nine.mcap")
    await_true(page, OPEN)
    seek(page, 6)
    look = {"x": 3.5, "y": 4.25, "scale": 0.0125}
    page.evaluate("(look) => gridbloom.connection.store.setView(look)", look)
    shared = open_group(page, "Share")
    shared.get_by_role("button", name="Create link").click()
    row = shared.get_by_role("listitem")
    expect(row).to_contain_text("costmap 6 of 9 · /costmap_raw")
    assert violations(page, ".share") == []

    watched = WatchedPage(visitor, server)
    guest = watched.page
    guest.goto(row.get_by_role("textbox").input_value())
    await_true(guest, OPEN)
    until("the costmap of the link", lambda: frame(guest)["index"] == 6)
    assert np.array_equal(shown(guest, 40, 50), np.full((40, 50), 100))
    seen = guest.evaluate("() => gridbloom.connection.store.view.peek()")
    assert (seen["x"], seen["y"]) == (look["x"], look["y"])
    for absent in (guest.get_by_role("tab", name="Share"), guest.get_by_role("button", name="All logs")):
        expect(absent).to_have_count(0)
    seek(guest, 3)
    assert frame(page)["index"] == 6
    assert watched.problems == []
    row.get_by_role("button", name="Revoke").click()
    page.get_by_role("dialog", name="Revoke this link?").get_by_role("button", name="Revoke").click()
    expect(guest.get_by_role("alert")).to_contain_text("This link was revoked")


def nine_costmaps(path: Path) -> None:
    """Write a recording of nine costmaps, each of one cost: 0, 20, 40, …"""
    geometry = GridGeometry(0.1, 40, 50, (1.0, 2.0, 0.0))
    with path.open("wb") as file:
        costs = [np.full((40, 50), 20 * k, np.uint8) for k in range(9)]
        made = (
            RecordedCostmap(t, t, "odom", "master", geometry, costs[t // 10**9]) for t in range(0, 9 * 10**9, 10**9)
        )
        write_costmaps(file, list(made))


def test_the_address_of_a_view_opens_it_again(page: Page, server: str, tmp_path: Path) -> None:
    nine_costmaps(tmp_path / "nine.mcap")
    page.goto(f"{server}/logs.html")
    page.set_input_files("input[type=file]", tmp_path / "nine.mcap")
    await_true(page, OPEN)
    seek(page, 6)
    view = {"x": 3.5, "y": 4.25, "scale": 0.0125}
    page.evaluate(
        "(view) => { const { store } = gridbloom.connection; store.view.value = view; store.viewHeld.value = true; }",
        view,
    )
    address = open_group(page, "Share").get_by_label("Address of this view").input_value()
    page.goto("about:blank")
    page.goto(address)
    await_true(page, OPEN)
    until("the costmap of the address", lambda: frame(page)["index"] == 6)
    assert page.evaluate("() => gridbloom.connection.store.view.peek()") == view
    assert not frame(page)["playing"]
    assert np.array_equal(shown(page, 40, 50), np.full((40, 50), 100))
