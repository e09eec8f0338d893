"""No page has a serious violation that axe-core finds. axe-core is read from node_modules: nothing is downloaded."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page

from tests.browser.looking import SECONDS

AXE = Path(__file__).parents[2] / "static" / "node_modules" / "axe-core" / "axe.min.js"
SERIOUS = ("serious", "critical")
READY = {
    "/": ".hero-map canvas",
    "/lecture.html": ".lesson-figure",
    "/lecture.html?present": ".on-slide",
    "/lab.html": ".picture canvas",
    "/logs.html": ".log-card",
}


def violations(page: Page) -> list[str]:
    """Return what axe-core finds serious on the page as it stands: the rule, and the first elements that break it."""
    page.evaluate(AXE.read_text())
    found: list[dict[str, Any]] = page.evaluate("async () => (await axe.run()).violations")
    return [
        f"{one['id']} ({one['impact']}): {one['help']}: {[node['html'][:120] for node in one['nodes'][:3]]}"
        for one in found
        if one["impact"] in SERIOUS
    ]


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("context", ["desktop", "phone"], indirect=True)
@pytest.mark.parametrize("path", READY)
def test_axe_finds_nothing_serious(page: Page, server: str, path: str, scheme) -> None:
    page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
    page.goto(server + path)
    page.locator(READY[path]).first.wait_for(timeout=SECONDS * 1000)
    page.wait_for_timeout(500)
    assert violations(page) == []


def test_axe_would_find_something(page: Page, server: str) -> None:
    page.goto(f"{server}/logs.html")
    page.evaluate("() => { document.body.innerHTML = '<main><button></button></main>'; }")
    assert any("button-name" in one for one in violations(page))
