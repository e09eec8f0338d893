"""A worker of a service that is killed: its lab page goes on with its world, from its story."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect

from tests.browser.looking import await_map, await_true, frame, settled_digest, until
from tests.browser.pages.test_replicas import session_of
from tests.browser.visits import visiting
from tests.server.workers.test_workers import serving

pytestmark = pytest.mark.moving

#: Resolves when the address has changed and stays as it is: one that was begun before may come first.
_SETTLED_ADDRESS = """async (before) => {
  for (let last = location.hash, same = 0; same < 120; last = location.hash) {
    await new Promise(requestAnimationFrame);
    same = location.hash === last && last !== before ? same + 1 : 0;
  }
}"""


def test_a_lab_whose_worker_is_killed_shows_its_map_again(browser: Browser, tmp_path: Path) -> None:
    with serving(tmp_path) as service, visiting(browser, service.address, reduced_motion="no-preference") as context:
        page = context.new_page()
        page.goto(f"{service.address}/lab.html")
        await_map(page)
        playing = page.evaluate("() => location.hash")
        page.get_by_role("button", name="Pause").click()
        # The world is made again from the address, which follows what is done a moment later.
        page.evaluate(_SETTLED_ADDRESS, playing)
        kept, before = settled_digest(page), session_of(page)
        os.kill(service.numbered()[int(before.partition(".")[0])], signal.SIGKILL)
        expect(page.locator(".toast")).to_contain_text("Its world was restored")
        await_true(
            page,
            "(b) => ![undefined, b].includes(gridbloom.connection.store.hello.peek()?.session)",
            before,
        )
        assert settled_digest(page) == kept
        page.get_by_role("button", name="Play").click()
        at = frame(page)["t"]
        until("the world to go on", lambda: frame(page)["t"] > at)
