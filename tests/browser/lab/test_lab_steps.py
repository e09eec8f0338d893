"""Stepping in Chromium: by cell, beam, scan and second, forwards and back."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.browser.looking import frame, map_bytes, open_group, settled_digest, until

# Every cell that was updated so far while stepping through the scan, with its current value.
_HELD = """() => {
  const { store } = gridbloom.connection;
  const stepping = store.stepping.peek();
  const map = store.map.peek();
  const held = new Map();
  const f = Math.fround;
  for (const { cell, evidence } of stepping.steps.slice(0, stepping.done)) {
    const name = `${cell.row} ${cell.col}`;
    const byte = map.cells.at(cell.row, cell.col);
    const { low, high } = map.geometry;
    const before = held.get(name) ?? (byte === 0 ? 0 : low + ((byte - 1) / 254) * (high - low));
    held.set(name, Math.min(high, Math.max(low, f(before + evidence))));
  }
  return [...held].map(([name, value]) => [...name.split(" ").map(Number), value]);
}"""


@pytest.fixture
def lab(open_lab: Callable[..., Page]) -> Page:
    """The lab, standing still."""
    return open_lab()


def by(page: Page, unit: str) -> None:
    """Choose how far a step goes."""
    open_group(page, "Steps").get_by_text(unit, exact=True).click()


def stepping(page: Page) -> dict[str, Any] | None:
    """Return the state of the stepping through a scan."""
    found: dict[str, Any] | None = page.evaluate(
        "() => { const w = gridbloom.connection.store.stepping.peek();"
        " return w && { done: w.done, of: w.steps.length, now: w.steps[Math.max(0, w.done - 1)] }; }"
    )
    return found


def test_scans_and_seconds_go_on_and_back(lab: Page) -> None:
    index, before = frame(lab)["index"], settled_digest(lab)
    lab.get_by_role("button", name="Back one scan").click()
    until("a scan less", lambda: frame(lab)["index"] == index - 1)
    lab.get_by_role("button", name="Forward one scan").click()
    until("the scan again", lambda: frame(lab)["index"] == index)
    assert settled_digest(lab) == before
    by(lab, "second")
    lab.get_by_role("button", name="Back one second").click()
    until("a second less", lambda: frame(lab)["index"] == index - 10)
    lab.get_by_role("button", name="Forward one second").click()
    until("the second again", lambda: frame(lab)["index"] == index)
    assert settled_digest(lab) == before


def test_a_scan_is_added_cell_by_cell_and_beam_by_beam(lab: Page) -> None:
    index = frame(lab)["index"]
    by(lab, "cell")
    lab.get_by_role("button", name="Forward one cell").click()
    until("the first cell of the next scan", lambda: (w := stepping(lab)) and w["done"] == 1)
    assert frame(lab)["index"] == index
    note = lab.locator(".steps-note")
    # The first beam that says something: those before it may have found nothing where the robot stands.
    expect(note).to_contain_text(re.compile(r"Beam \d+ of 360, cell 1 of"))
    expect(note).to_contain_text("Error term")
    expect(note).to_contain_text("Passed: −2.00 − 0.40 = −2.40, clamped to −2.00")  # the robot's own cell
    lab.get_by_role("button", name="Forward one cell").click()
    expect(note).to_contain_text("cell 2 of")
    lab.get_by_role("button", name="Back one cell").click()
    expect(note).to_contain_text("cell 1 of")
    # Zoom in a cell is large, and afterwards everything is seen again.
    cell_px = "() => { const s = gridbloom.connection.store;"
    cell_px += " return Math.round(s.map.peek().geometry.resolution / s.view.peek().scale); }"
    far = lab.evaluate(cell_px)
    near = lab.get_by_role("button", name="Zoom in")
    near.click()
    until("large cells", lambda: lab.evaluate(cell_px) == 16)
    near.click()
    until("the whole again", lambda: lab.evaluate(cell_px) == far)
    by(lab, "beam")
    lab.get_by_role("button", name="Forward one beam").click()
    until("the end of the first beam", lambda: (w := stepping(lab)) and w["now"]["place"] == w["now"]["of"] - 1)
    expect(note).to_contain_text("Hit: ")
    first = stepping(lab)
    lab.get_by_role("button", name="Forward one beam").click()
    until("another beam", lambda: (w := stepping(lab)) and first and w["now"]["beam"] > first["now"]["beam"])
    # All of it: what the page has painted is what the mapper makes of the scan.
    lab.evaluate("() => { const s = gridbloom.connection.store; const w = s.stepping.peek();"
                 " s.stepping.value = { ...w, done: w.steps.length }; }")  # fmt: skip
    held = lab.evaluate(_HELD)
    assert len(held) > 300
    lab.get_by_role("button", name="Forward one beam").click()
    until("the scan in the map", lambda: frame(lab)["index"] == index + 1 and stepping(lab) is None)
    settled_digest(lab)
    after = map_bytes(lab)
    step = (after["high"] - after["low"]) / 254
    same = 0
    for row, col, value in held:
        byte = after["bytes"][row * after["cols"] + col]
        same += abs(after["low"] + (byte - 1) * step - value) <= 1.1 * step
    # Readings come rounded to a millimetre: on a border of cells a beam may end in the neighbour.
    assert same >= 0.98 * len(held)


def test_stepping_back_removes_the_last_beam_and_play_ends_stepping(lab: Page) -> None:
    index = frame(lab)["index"]
    by(lab, "beam")
    lab.get_by_role("button", name="Back one beam").click()
    until("the last beam to be out", lambda: (w := stepping(lab)) and w["done"] < w["of"])
    assert frame(lab)["index"] == index - 1
    lab.get_by_role("button", name="Play").click()
    until("time to go on", lambda: frame(lab)["index"] > index)
    assert stepping(lab) is None
    expect(lab.locator(".steps-note")).to_have_count(0)


def test_models_without_an_order_of_cells_show_a_notice(lab: Page) -> None:
    lab.evaluate("() => gridbloom.connection.store.setParameter('update', 'per_scan')")
    by(lab, "cell")
    lab.get_by_role("button", name="Forward one cell").click()
    expect(lab.locator(".toast").first).to_contain_text("update per beam")
    assert stepping(lab) is None
