"""Every sensor model in the lab's profile, in real Chromium: its shape, its handles, and the sonar ring's cones."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.browser.looking import SECONDS, await_map, drag, frame, map_digest, settled_digest, until


@pytest.fixture
def lab(page: Page, server: str) -> Iterator[Page]:
    """The lab, paused with a small sensor, so that wide beams are quickly mapped again."""
    page.goto(f"{server}/lab.html")
    await_map(page)
    page.get_by_role("button", name="Pause").click()
    until("the robot to stand", lambda: not frame(page)["playing"])
    yield page
    page.evaluate(
        "() => fetch(`/api/sessions/${new URLSearchParams(location.search).get('session')}`, { method: 'DELETE' })"
    )


def value(page: Page, name: str) -> Any:
    """Return a mapping parameter as the page has it."""
    return page.evaluate("(name) => gridbloom.connection.store.mapping.values.peek()[name]", name)


def choose(page: Page, model: str) -> None:
    """Take an inverse sensor model."""
    page.locator(".lab-settings select").first.select_option(model)
    until("the model", lambda: value(page, "model") == model)


THIN = [
    ("smooth_ramp", "Far edge of the ramp", (40, 0), "sigma"),
    ("smooth_ramp", "Hit increment", (0, -30), "log_odds_hit"),
    ("hit_counting", "Change by the first hit", (0, -30), "prior_weight"),
    ("hit_counting", "Change by the first miss", (0, 30), "prior_weight"),
    ("hit_counting", "Far edge of the hit window", (40, 0), "window"),
]


@pytest.mark.parametrize(("model", "handle", "by", "name"), THIN)
def test_a_thin_model_has_its_own_handles(lab: Page, model: str, handle: str, by: tuple[int, int], name: str) -> None:
    choose(lab, model)
    settled_digest(lab)
    before, map_before = value(lab, name), map_digest(lab)
    grip = lab.locator("figure.profile").get_by_role("slider", name=handle, exact=True)
    drag(lab, grip.locator(".handle-grab"), *by)
    until(f"{name} to move", lambda: value(lab, name) != before)
    until("the map to follow", lambda: map_digest(lab) != map_before)


def test_a_ring_of_sonars_brings_its_cone_and_the_cone_has_handles(lab: Page) -> None:
    lab.locator(".lab-row").get_by_text("sonar ring", exact=True).click()
    until("the cone", lambda: value(lab, "model") == "sonar_cone")
    profile = lab.locator("figure.profile")
    canvas = profile.locator("canvas.cone-cells")
    expect(canvas).to_be_visible(timeout=SECONDS * 1000)
    ink = "(c) => { const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0;"
    ink += " for (let i = 0; i < d.length; i += 4) if (d[i + 3] > 200 && d[i + 2] - d[i] > 40) n++; return n; }"
    free = canvas.evaluate(ink)
    assert free > 1000  # the cells before the arc are painted as passed
    opening = profile.get_by_role("slider", name="Opening angle")
    before = value(lab, "opening")
    settled_digest(lab)
    map_before = map_digest(lab)
    drag(lab, opening.locator(".handle-grab"), 0, -30)
    until("the cone to open", lambda: value(lab, "opening") > before)
    until("the map to follow", lambda: map_digest(lab) != map_before)
    assert canvas.evaluate(ink) != free  # repainted, and to another scale where it would not fit
    opening.focus()
    wide = value(lab, "opening")
    lab.keyboard.press("ArrowLeft")
    until("the cone to close a little", lambda: value(lab, "opening") < wide)
    reading = profile.get_by_role("slider", name="Measured range z", exact=True)
    z = float(reading.get_attribute("aria-valuenow") or "nan")
    reading.focus()
    lab.keyboard.press("ArrowLeft")
    until("the reading", lambda: float(reading.get_attribute("aria-valuenow") or "nan") < z)
    choose(lab, "moravec_elfes")
    expect(profile.locator("figcaption")).to_contain_text("no log-odds that are added")
