"""What the front page fetches at its start, and when."""

from __future__ import annotations

import gzip
import re

from playwright.sync_api import Browser, expect

from server.http.page_files import PLACES
from tests.browser.visits import visiting

SCRIPTS = re.compile(r'<(?:script type="module"|link rel="modulepreload")[^>]* (?:src|href)="/([^"]+)"')


def script_bytes(page: str) -> int:
    """Return the size of the scripts that a built page loads at its start, compressed."""
    place = next(place for place in PLACES if (place / page).is_file())
    names = SCRIPTS.findall((place / page).read_text())
    assert names, page
    return sum(len(gzip.compress((place / name).read_bytes())) for name in names)


def test_the_front_page_loads_no_code_of_other_pages(browser: Browser, server: str) -> None:
    """It shows a world and its map, as the lab does, without the lab's panels."""
    assert script_bytes("index.html") < 0.7 * script_bytes("lab.html")
    with visiting(browser, server) as context:
        page = context.new_page()
        page.goto(server)
        expect(page.locator(".hero-facts")).to_contain_text("scans")
        loaded = page.evaluate("performance.getEntriesByType('resource').map(({ name }) => name)")
    assert not [name for name in loaded if re.search(r"/(shared|lab|logs|lecture)-[\w-]+\.(js|css)$", name)]


def test_the_world_is_requested_before_the_page_is_rendered(browser: Browser, server: str) -> None:
    with visiting(browser, server) as context:
        page = context.new_page()
        page.add_init_script(
            """new MutationObserver(() => {
                if (document.querySelector(".hero-curve svg")) window.renderedAt ??= performance.now();
            }).observe(document, { childList: true, subtree: true })"""
        )
        page.goto(server)
        expect(page.locator(".hero-facts")).to_contain_text("scans")
        rendered, requested = page.evaluate(
            "[renderedAt, performance.getEntriesByName(`${location.origin}/api/sessions`)[0].startTime]"
        )
    assert requested <= rendered
