"""The lab in Chromium: the world and the belief, the profile and its handles, the sliders, the robot."""

from __future__ import annotations

import re
from collections.abc import Callable
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import BrowserContext, Locator, Page, expect

from mapper.mapping.parameters import LOG_ONLY, PARAMETERS
from tests.browser.cutting_proxy import cutting_proxy
from tests.browser.looking import (
    await_map,
    drag,
    drag_along,
    frame,
    map_digest,
    observed,
    open_group,
    place_on,
    settled_digest,
    still,
    until,
)
from tests.marks import also_long_rows

pytestmark = pytest.mark.moving

NUMBERS = [row for row in PARAMETERS if row.kind == "number" and row.name not in LOG_ONLY]
SLIDERS = {
    "fixed_increments": [row for row in NUMBERS if not row.only_for or "fixed_increments" in row.only_for],
    "step_window": [row for row in NUMBERS if row.only_for and "step_window" in row.only_for],
}


@pytest.fixture
def lab(open_lab: Callable[..., Page]) -> Page:
    """The lab, standing still with a map of its own on show."""
    return open_lab()


@pytest.fixture
def still_lab(page: Page, open_lab: Callable[..., Page]) -> Page:
    """That lab without motion: a map that changes many times is painted once for each, and its cells do not glow."""
    page.emulate_media(reduced_motion="reduce")
    return open_lab()


def profile(page: Page) -> str:
    """Contents of the profile figure."""
    return str(page.locator("figure.profile").inner_html())


#: The group of the dock with the rows of each group of the table.
DOCK_GROUPS = {"model": "Sensor model", "update": "Map", "map": "Map", "mount": "Sensor"}


def choose_model(page: Page, model: str) -> None:
    """Take an inverse sensor model."""
    page.locator(".lab-settings select").first.select_option(model)
    until(
        "the model to be taken",
        lambda: page.evaluate("() => gridbloom.connection.store.mapping.values.value.model") == model,
    )


def test_the_map_fills_in_while_the_robot_walks(page: Page, server: str) -> None:
    page.goto(f"{server}/lab.html")
    await_map(page)
    before, pose = observed(page), frame(page)["pose"]
    until("new cells", lambda: observed(page) > before + 200)
    until("the robot to have moved", lambda: frame(page)["pose"] != pose)
    expect(page).to_have_url(re.compile("session="))


@pytest.mark.parametrize(
    ("model", "every"), [*((model, 5) for model in SLIDERS), *also_long_rows(*((model, 1) for model in SLIDERS))]
)
def test_each_slider_changes_the_map_and_the_profile_and_back(still_lab: Page, model: str, every: int) -> None:
    """One slider in ``every`` is dragged."""
    if model != "fixed_increments":
        choose_model(still_lab, model)
    first = settled_digest(still_lab)
    for row in SLIDERS[model][::every]:
        profile_before = profile(still_lab)
        open_group(still_lab, DOCK_GROUPS[row.group])
        slider = still_lab.get_by_role("slider", name=row.label, exact=True).and_(still_lab.locator("input"))
        still(slider)
        box = slider.bounding_box()
        assert box is not None
        value = still_lab.evaluate("(name) => gridbloom.connection.store.mapping.values.value[name]", row.name)
        fraction = float(slider.input_value()) / 1000
        # Grab the thumb where it is, and go a quarter of the way towards the farther end.
        x, y = box["x"] + 10 + fraction * (box["width"] - 20), box["y"] + box["height"] / 2
        drag_along(still_lab, (x, y), (x + (0.25 if fraction < 0.5 else -0.25) * box["width"], y), steps=8)
        assert settled_digest(still_lab) != first, row.name
        if row.group == "model" or row.name == "resolution":
            assert profile(still_lab) != profile_before, row.name
        still_lab.evaluate("([name, value]) => gridbloom.connection.store.setParameter(name, value)", [row.name, value])
        assert settled_digest(still_lab) == first, row.name


HANDLES = [
    ("Miss increment", (0, 30), True),
    ("Hit increment", (0, -30), True),
    ("Near edge of the hit window", (-40, 0), True),
    ("Far edge of the hit window", (40, 0), True),
    ("Max range", (-160, 0), True),
    ("Measured range z", (-60, 0), False),  # what this one beam would have said: the map has its own readings
]


def test_each_handle_of_the_curve_changes_profile_and_map_by_mouse_and_keys(still_lab: Page) -> None:
    first = settled_digest(still_lab)
    for name, by, changes_map in HANDLES:
        profile_before = profile(still_lab)
        handle = still_lab.locator("figure.profile").get_by_role("slider", name=name, exact=True)

        def value(handle: Locator = handle) -> float:
            return float(handle.get_attribute("aria-valuenow") or "nan")

        before = value()
        drag(still_lab, handle.locator(".handle-grab"), *by)
        until(f"{name} to move", lambda before=before, value=value: value() != before)  # type: ignore[misc]
        assert profile(still_lab) != profile_before, name
        assert (settled_digest(still_lab) != first) == changes_map, name
        before = value()
        handle.focus()
        horizontal = handle.get_attribute("aria-orientation") == "horizontal"
        still_lab.keyboard.press("ArrowLeft" if horizontal else "ArrowDown")
        until(f"{name} to answer", lambda before=before, value=value: value() != before)  # type: ignore[misc]
        still_lab.get_by_role("button", name="Reset to defaults").click()
        assert settled_digest(still_lab) == first, name


def test_a_click_teleports_the_robot_and_new_cells_fill_in_around_it(lab: Page) -> None:
    x, y = frame(lab)["pose"][:2]
    # The far end of the office: wherever the robot is, the other side.
    bounds = lab.evaluate("() => gridbloom.connection.store.world.peek().bounds")
    target = [bounds[2] - 2.5 if x < (bounds[0] + bounds[2]) / 2 else bounds[0] + 2.5, bounds[1] + 2.5]
    unseen = lab.evaluate("(xy) => gridbloom.readState(xy)", target)
    before = observed(lab)
    lab.mouse.click(*place_on(lab.locator(".picture").first, target))
    until("the robot to be there", lambda: abs(frame(lab)["pose"][0] - x) > 3.0)
    settled_digest(lab)
    assert observed(lab) > before + 200
    there = frame(lab)["pose"]
    assert abs(there[0] - target[0]) < 1.5
    assert abs(there[1] - target[1]) < 1.5
    around = [[there[0] + dx, there[1] + dy] for dx, dy in ((0.5, 0.0), (-0.5, 0.0), (0.0, 0.5), (0.0, -0.5))]
    states = [lab.evaluate("(xy) => gridbloom.readState(xy)?.byte", place) for place in around]
    assert unseen is None or unseen["byte"] == 0 or there[:2] != [x, y]
    assert any(byte for byte in states)


def test_a_teleport_into_a_wall_moves_beside_it_and_shows_a_notice(lab: Page) -> None:
    wall = lab.evaluate(
        "() => { const [first] = gridbloom.connection.store.world.peek().polygons;"
        " const n = first.length; return [0, 1].map((k) => first.reduce((sum, p) => sum + p[k], 0) / n); }"
    )
    lab.mouse.click(*place_on(lab.locator(".picture").first, wall))
    expect(lab.locator(".toast").first).to_contain_text(re.compile("nearest free", re.IGNORECASE))


def test_the_robot_drives_by_the_keyboard(lab: Page) -> None:
    lab.get_by_role("button", name="Play").click()
    lab.locator(".picture").first.focus()
    lab.keyboard.down("KeyA")
    until("the robot to be in our hands", lambda: frame(lab)["auto"] is False)
    yaw = frame(lab)["pose"][2]
    until("the robot to turn", lambda: abs(frame(lab)["pose"][2] - yaw) > 0.3)
    lab.keyboard.up("KeyA")


def test_hovering_a_cell_reads_it(lab: Page) -> None:
    lab.mouse.move(*place_on(lab.locator(".picture").nth(1), frame(lab)["pose"][:2]))
    readout = lab.locator(".readout dl")
    # Beams start in the robot's own cell, so it is as free as can be: the lower clamp, p = 1 − 1 / (1 + e^−2).
    expect(readout).to_contain_text("free")
    expect(readout).to_contain_text("−2.00")
    expect(readout).to_contain_text("0.119")


def test_the_page_recovers_from_a_lost_connection_without_a_reload(context, server: str) -> None:
    # On a page that is not watched for console errors: a refused connection is one, and is what the test is about.
    with cutting_proxy(urlsplit(server).port or 0) as proxy:
        page = context.new_page()
        page.goto(f"http://127.0.0.1:{proxy.port}/lab.html")
        await_map(page)
        page.evaluate("() => { window.notReloaded = true; }")
        session = page.url.partition("#")[0]
        proxy.cut()
        expect(page.locator(".lab-status")).to_have_text("The server does not answer. The page tries again by itself.")
        seen = frame(page)["index"]
        proxy.mend()
        expect(page.locator(".lab-status")).to_have_text("live")
        until("the map to go on", lambda: frame(page)["index"] > seen + 5)
        assert page.evaluate("() => window.notReloaded") is True
        assert page.url.partition("#")[0] == session  # what follows tells what happened meanwhile
        # What was missed meanwhile came after: the browser's map is the server's.
        page.get_by_role("button", name="Pause").click()
        until("the robot to stand", lambda: not frame(page)["playing"])
        kept = settled_digest(page)
        page.reload()
        await_map(page)
        until("the same map after a reload", lambda: map_digest(page) == kept)


def test_another_world_is_another_map(lab: Page) -> None:
    before = settled_digest(lab)
    lab.locator("label", has_text="World").locator("select").select_option("room")
    until("another map", lambda: map_digest(lab) != before)
    assert lab.evaluate("() => gridbloom.connection.store.world.peek().name") == "room"


def test_the_link_shows_the_same_session_to_another_visitor(lab: Page, visitor: BrowserContext) -> None:
    page = visitor.new_page()
    page.goto(lab.url)
    await_map(page)
    assert settled_digest(page) == settled_digest(lab)
