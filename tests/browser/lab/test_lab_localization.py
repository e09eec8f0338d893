"""The lab localizes its robot, in Chromium: it is found, kidnapped by a click, and found again."""

from __future__ import annotations

import re
from collections.abc import Callable

from playwright.sync_api import Page, expect

from tests.browser.looking import await_true, centre, drag_along, open_group

_MESSAGE = "() => gridbloom.connection.store.part('localization').message.peek()"
_FOUND = f"() => {{ const m = ({_MESSAGE})(); return m?.is_converged && m.error_m < 0.5; }}"


def test_the_robot_is_kidnapped_by_a_click_and_found_again(open_lab: Callable[..., Page]) -> None:
    page = open_lab()
    open_group(page, "Localize")
    page.get_by_role("button", name="Find the robot").click()
    await_true(page, "() => gridbloom.connection.store.layers.content('particles').peek()?.columns[0].length > 99")
    page.evaluate("() => gridbloom.connection.store.send({ type: 'play' })")
    await_true(page, _FOUND)
    expect(page.get_by_text(re.compile("^Found"))).to_be_visible()
    # The world's picture shows the whole floor: a point in another room, right of the middle.
    world = page.get_by_role("application").first
    box = world.bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 0.86 * box["width"], box["y"] + 0.42 * box["height"])
    await_true(page, f"() => ({_MESSAGE})().error_m > 2")
    await_true(page, _FOUND)
    page.get_by_role("switch", name="Likelihood field").click()
    await_true(page, "() => gridbloom.connection.store.layers.grid('likelihood_field').map.peek() !== null")
    # The sensor model is grabbed: the filter that runs goes on with it, and the field follows.
    panel = page.get_by_role("tabpanel", name="Localize")
    panel.locator("summary", has_text="Sensor model").click()
    sigma = panel.get_by_role("slider", name="sigma_hit", exact=True)
    updates = page.evaluate(f"() => ({_MESSAGE})().n_updates")
    x, y = centre(sigma)
    drag_along(page, (x, y), (x + 60, y), steps=4)
    await_true(page, f"() => ({_MESSAGE})().values.sigma_hit > 0.4")
    assert page.evaluate(f"() => ({_MESSAGE})().n_updates") >= updates
    sigma.press("Home")
    await_true(page, f"() => ({_MESSAGE})().values.sigma_hit === 0.005")
    panel.locator("summary", has_text="Motion model").click()
    dots = panel.locator(".motion-fan .dots")
    before = dots.get_attribute("d")
    panel.get_by_role("button", name="End of the motion").press("ArrowUp")
    expect(dots).not_to_have_attribute("d", before or "")
    page.get_by_role("button", name="End", exact=True).click()
    await_true(page, f"() => !({_MESSAGE})().is_on")
    expect(page.get_by_text("Found", exact=True)).to_have_count(0)
