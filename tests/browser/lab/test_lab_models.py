"""Every sensor model in the lab's profile, in Chromium: shape, handles, and cones of the sonar ring."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.browser.looking import drag, open_group, settled_digest, until


@pytest.fixture
def lab(open_lab: Callable[..., Page]) -> Page:
    """The lab, standing still."""
    return open_lab()


def value(page: Page, name: str) -> Any:
    """Return a mapping parameter as the page has it."""
    return page.evaluate("(name) => gridbloom.connection.store.mapping.values.peek()[name]", name)


def choose(page: Page, model: str) -> None:
    """Take an inverse sensor model."""
    open_group(page, "Sensor model").locator("select").first.select_option(model)
    until("the model", lambda: value(page, "model") == model)


THIN = [
    ("smooth_ramp", "Far edge of the ramp", (40, 0), "sigma"),
    ("smooth_ramp", "Hit increment", (0, -30), "log_odds_hit"),
    ("hit_counting", "Change by the first hit", (0, -30), "prior_weight"),
    ("hit_counting", "Change by the first miss", (0, 30), "prior_weight"),
    ("hit_counting", "Far edge of the hit window", (40, 0), "window"),
]


def test_each_thin_model_has_its_own_handles(lab: Page) -> None:
    for model, handle, by, name in THIN:
        choose(lab, model)
        map_before, before = settled_digest(lab), value(lab, name)
        grip = lab.locator("figure.profile").get_by_role("slider", name=handle, exact=True)
        drag(lab, grip.locator(".handle-grab"), *by)
        until(f"{name} to move", lambda name=name, before=before: value(lab, name) != before)  # type: ignore[misc]
        assert settled_digest(lab) != map_before, handle
        lab.evaluate("() => gridbloom.connection.store.reset()")


def test_a_sonar_ring_selects_the_cone_model_with_its_handles(lab: Page) -> None:
    open_group(lab, "Sensor").get_by_text("sonar ring", exact=True).click()
    until("the cone", lambda: value(lab, "model") == "sonar_cone")
    profile = lab.locator("figure.profile")
    canvas = profile.locator("canvas.cone-cells")
    expect(canvas).to_be_visible()
    ink = "(c) => { const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0;"
    ink += " for (let i = 0; i < d.length; i += 4) if (d[i + 3] > 200 && d[i + 2] - d[i] > 40) n++; return n; }"
    free = canvas.evaluate(ink)
    assert free > 1000  # the cells before the arc are painted as passed
    opening = profile.get_by_role("slider", name="Opening angle")
    before = value(lab, "opening")
    map_before = settled_digest(lab)
    drag(lab, opening.locator(".handle-grab"), 0, -30)
    until("the cone to open", lambda: value(lab, "opening") > before)
    assert settled_digest(lab) != map_before
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
    expect(open_group(lab, "Sensor model").locator(".profile-caption")).to_contain_text("no log-odds are added")
