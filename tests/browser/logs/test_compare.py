"""Two maps of one log in one picture, in Chromium: pixels, numbers, keys, and the link that restores it."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from playwright.sync_api import Page, expect

from tests.browser.looking import BASE64, await_true, drag, frame, frames, open_group, settled_digest, until
from tests.browser.pages.test_axe import nothing_wrong, told_sliders

# The states of both maps on the lattice of B: 0 free, 1 occupied, 2 unknown; and the bytes of each.
_BOTH = f"""() => {{
  const {{ store }} = gridbloom.connection;
  const b = store.map.peek(), a = store.second.peek().map.peek();
  const place = [0, 1].map((i) => Math.round((b.geometry.origin[i] - a.geometry.origin[i]) / b.geometry.resolution));
  const bytes = {{ a: [], b: [] }};
  for (let row = 0; row < b.geometry.rows; row++)
    for (let col = 0; col < b.geometry.cols; col++) {{
      bytes.a.push(a.cells.at(row + place[1], col + place[0]));
      bytes.b.push(b.cells.at(row, col));
    }}
  const text = {BASE64};
  return {{ a: text(bytes.a), b: text(bytes.b), geometry: b.geometry }};
}}"""


def evaluate(page: Page, script: str, argument: Any = None) -> Any:
    return page.evaluate(script, argument)


def store(page: Page, signal: str) -> Any:
    return evaluate(page, f"() => gridbloom.connection.store.{signal}.peek()")


def address(page: Page) -> str:
    return str(evaluate(page, "() => location.href"))


def numbers(page: Page) -> dict[str, Any]:
    return dict((store(page, 'part("comparison").message') or {}).get("numbers") or {})


@pytest.fixture
def viewer(page: Page, server: str) -> Page:
    """The sample log, paused at its end."""
    logs = page.request.get(f"{server}/api/logs").json()["logs"]
    sample = next(log["id"] for log in logs if log["source"] == "sample")
    page.goto(f"{server}/logs.html?log={sample}")
    await_true(page, "() => window.gridbloom && gridbloom.connection.store.frame.peek()")
    count = frame(page)["count"]
    evaluate(
        page,
        "(index) => { for (const command of [{ type: 'pause' }, { type: 'seek', index }])"
        " gridbloom.connection.store.send(command); }",
        count,
    )
    until("the end of the log", lambda: frame(page)["index"] == count)
    return page


def both(page: Page) -> tuple[NDArray[np.uint8], NDArray[np.uint8], dict[str, Any]]:
    """Bytes of A and B, (rows, cols), on B's lattice."""
    held = evaluate(page, _BOTH)
    geometry = held["geometry"]
    shape = geometry["rows"], geometry["cols"]
    a, b = (np.frombuffer(base64.b64decode(held[side]), dtype=np.uint8).reshape(shape) for side in "ab")
    return a, b, geometry


def colour(page: Page, geometry: dict[str, Any], cell: Any) -> list[int]:
    """The painted colour at a cell's centre."""
    x, y = (geometry["origin"][i] + (cell[1 - i] + 0.5) * geometry["resolution"] for i in (0, 1))
    found = evaluate(page, "(xy) => gridbloom.colourAt(xy)", [float(x), float(y)])
    assert found is not None, f"cell {cell} lies outside the picture"
    return list(found[:3])


def look_by(page: Page, name: str) -> None:
    page.locator(".compare-mode .choice-option", has_text=name).click()


def open_cells(page: Page, geometry: dict[str, Any], found: NDArray[np.bool_], n: int) -> NDArray[np.int64]:
    """Some of the cells that were found, spread over the map, away from what is painted over it."""
    poses = np.array(store(page, "trajectory")["poses"])
    cells = np.argwhere(found)
    places = np.array(geometry["origin"][:2]) + (cells[:, ::-1] + 0.5) * geometry["resolution"]
    away = np.min(np.linalg.norm(places[:, None] - poses[None, ::3], axis=2), axis=1) > 0.5
    # The newest scan's beams are painted too.
    pose = frame(page)["pose"]
    away &= np.linalg.norm(places - np.array(pose[:2]), axis=1) > 2.0
    kept = cells[away]
    assert len(kept) >= n, "too few cells to look at"
    return np.asarray(kept[np.linspace(0, len(kept) - 1, n).astype(int)])


def test_a_map_with_kept_settings_is_compared_with_the_present_one(viewer: Page, server: str) -> None:
    open_group(viewer, "Compare")
    viewer.get_by_role("button", name="Save as A").click()
    until("the numbers", lambda: numbers(viewer).get("max_difference") == 0.0)
    kept = store(viewer, "mapping.values")["log_odds_miss"]
    before = settled_digest(viewer)
    sliders = open_group(viewer, "Settings").get_by_role("slider", name="Miss increment", exact=True)
    slider = viewer.locator("input").and_(sliders)
    drag(viewer, slider, 60, 0)
    until("other numbers", lambda: numbers(viewer).get("max_difference", 0.0) > 0.3)
    assert settled_digest(viewer) != before
    assert store(viewer, "mapping.values")["log_odds_miss"] != kept
    open_group(viewer, "Compare")
    told = viewer.locator(".compare-differing")
    expect(told).to_contain_text("Miss increment")

    # What the browser holds of both maps, against the numbers.
    _, _, geometry = both(viewer)
    low, high = geometry["low"], geometry["high"]

    def states(byte: NDArray[np.uint8]) -> NDArray[np.int64]:
        p = 1.0 / (1.0 + np.exp(-(low + (byte - 1.0) / 254.0 * (high - low))))
        return np.select([byte == 0, p > 0.65, p < 0.25], [2, 1, 0], 2)

    def counted() -> list[list[int]]:
        sa, sb = (states(byte) for byte in both(viewer)[:2])
        return [[int(np.sum((sa == i) & (sb == j))) for j in range(3)] for i in range(3)]

    # Maps and numbers of the last step of the slider come one after the other.
    until("the numbers of these maps", lambda: numbers(viewer)["states"] == counted())
    a, b, _ = both(viewer)
    sa, sb = states(a), states(b)
    table = numbers(viewer)["states"]
    assert sum(map(sum, table)) == numbers(viewer)["cells"] == a.size
    shown = viewer.locator(".compare-states .compare-mark").all_inner_texts()
    assert [int(text.replace(",", "")) for text in shown] == [n for row in table for n in row]

    # Left of the divider the pixels are A's, right of it B's.
    viewer.mouse.move(2, 2)
    differ = open_cells(viewer, geometry, (sa != sb) & (a > 0) & (b > 0), 14)
    divider = viewer.get_by_role("slider", name="Divider between A")
    told_sliders(viewer)
    divider.focus()
    viewer.keyboard.press("End")
    only_a = [colour(viewer, geometry, cell) for cell in differ]
    viewer.keyboard.press("Home")
    only_b = [colour(viewer, geometry, cell) for cell in differ]
    assert all(left != right for left, right in zip(only_a, only_b, strict=True))
    for _ in range(5):
        viewer.keyboard.press("PageUp")
    drag(viewer, viewer.locator(".compare-grip"), 37, 0)
    box = viewer.locator(".picture").first.bounding_box()
    assert box is not None
    at = store_of_divider(viewer) * box["width"]
    assert 0.5 * box["width"] < at < 0.6 * box["width"]
    sides = set()
    for cell, left, right in zip(differ, only_a, only_b, strict=True):
        x = evaluate(
            viewer,
            "(xy) => gridbloom.screen(xy)[0]",
            [float(geometry["origin"][i] + (cell[1 - i] + 0.5) * geometry["resolution"]) for i in (0, 1)],
        )
        if abs(x - at) < 2.0:
            continue
        sides.add(x < at)
        assert colour(viewer, geometry, cell) == (left if x < at else right)
    assert sides == {True, False}

    # The difference has its sign's colour: orange is more occupied in B, blue more free.
    look_by(viewer, "Difference")
    low_to_high = (high - low) / 254.0 * (b.astype(float) - a)
    for sign in (1.0, -1.0):
        much = (sign * low_to_high > 0.8) & (a > 0) & (b > 0)
        if np.count_nonzero(much) < 40:
            continue
        for cell in open_cells(viewer, geometry, much, 5):
            red, _, blue = colour(viewer, geometry, cell)
            assert sign * (red - blue) > 0
    # Added, what both say counts together: a cell is coloured by the sum, whatever A or B alone would make of it.
    look_by(viewer, "Merge")
    expect(viewer.locator(".compare-mode")).to_contain_text("each scan counts twice")
    la, lb = (low + (byte.astype(float) - 1.0) / 254.0 * (high - low) for byte in (a, b))
    for sign in (1.0, -1.0):
        sure = (sign * (la + lb) > 0.8) & (a > 0) & (b > 0)
        torn = sure & (np.minimum(sign * la, sign * lb) < 0.0)
        for cell in open_cells(viewer, geometry, torn if np.count_nonzero(torn) > 40 else sure, 5):
            red, _, blue = colour(viewer, geometry, cell)
            assert sign * (red - blue) > 0
    x, y = (float(geometry["origin"][i] + (cell[1 - i] + 0.5) * geometry["resolution"]) for i in (0, 1))
    picture = viewer.locator(".picture").first.bounding_box()
    assert picture is not None
    px, py = evaluate(viewer, "(xy) => gridbloom.screen(xy)", [x, y])
    viewer.mouse.move(picture["x"] + px, picture["y"] + py)
    told_sum = viewer.locator(".compare-readout div", has_text="A + B − ℓ₀").locator("dd")
    until(
        "the sum of the cell",
        lambda: (
            abs(float(told_sum.inner_text().replace("−", "-")) - la[tuple(cell)] - lb[tuple(cell)])
            <= (high - low) / 254.0 + 0.006
        ),
    )
    look_by(viewer, "Difference")
    mark = viewer.get_by_role("button", name="cells occupied in A, free in B")
    mark.click()
    expect(mark).to_have_attribute("aria-pressed", "true")
    viewer.mouse.move(2, 2)
    marked = open_cells(viewer, geometry, (sa == 1) & (sb == 0), 4)
    accent = evaluate(
        viewer,
        "() => { const span = document.createElement('span'); span.style.color = 'var(--mark)';"
        " document.body.append(span); const found = getComputedStyle(span).color; span.remove();"
        " return found.match(/\\d+/g).map(Number); }",
    )
    assert {tuple(colour(viewer, geometry, cell)) for cell in marked} == {tuple(accent)}

    # With less motion wanted the maps do not blink by themselves; a key turns them.
    look_by(viewer, "Blink")
    viewer.locator("body").press("b")
    expect(viewer.locator(".compare-name")).to_have_attribute("data-side", "b")
    frames(viewer, 80)
    expect(viewer.locator(".compare-name")).to_have_attribute("data-side", "b")
    viewer.locator("body").press("b")
    expect(viewer.locator(".compare-name")).to_have_attribute("data-side", "a")
    nothing_wrong(viewer)

    # Why in A: with the increment that it kept.
    cell = differ[0]
    place = [float(geometry["origin"][i] + (cell[1 - i] + 0.5) * geometry["resolution"]) for i in (0, 1)]
    evaluate(viewer, "(place) => gridbloom.connection.store.explain(place)", place)
    until("the answer", lambda: store(viewer, "why"))
    assert store(viewer, "why")["layer"] == "second_map"
    assert all(t["increment"] == pytest.approx(kept) for t in store(viewer, "why")["contributions"] if not t["hit"])
    viewer.locator(".why .choice-option", has_text="In B").click()
    until("the other answer", lambda: (why := store(viewer, "why")) and why["layer"] == "map")
    viewer.keyboard.press("Escape")

    # The address opens all of it again, here and, when this session has ended, in another one.
    until("the address", lambda: "#compare=" in address(viewer) and "blink" in address(viewer))
    link, told_before = address(viewer), numbers(viewer)
    session = evaluate(viewer, "() => new URLSearchParams(location.search).get('session')")
    viewer.goto("about:blank")  # the end of a session ends the examination that a page may still wait for
    assert viewer.request.delete(f"{server}/api/sessions/{session}").status == 204
    viewer.goto(link.replace(f"&session={session}", ""))
    until("the same numbers", lambda: store_is_there(viewer) and numbers(viewer) == told_before)
    expect(viewer.locator(".compare-name")).to_have_attribute("data-side", "a")
    assert store(viewer, "compared")["values"]["log_odds_miss"] == kept
    open_group(viewer, "Compare")
    viewer.get_by_role("button", name="End comparison").click()
    expect(viewer.locator(".compare-name")).to_have_count(0)
    until("a clean address", lambda: "#" not in address(viewer))


def store_of_divider(page: Page) -> float:
    return (
        float(page.get_by_role("slider", name="Divider between A").evaluate("(el) => parseFloat(el.style.left)")) / 100
    )


def store_is_there(page: Page) -> bool:
    return bool(evaluate(page, "() => Boolean(window.gridbloom)"))
