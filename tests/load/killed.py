"""Time from the death of a worker until the lab page that it served shows its map again, made from its story."""

from __future__ import annotations

import os
import signal
import statistics
import tempfile
import time
from pathlib import Path

from playwright.sync_api import Browser

from tests.browser.looking import await_map, await_true
from tests.browser.pages.test_replicas import session_of
from tests.browser.running import running_chromium
from tests.browser.visits import visiting
from tests.server.workers.test_workers import serving

WANTED_S, REPETITIONS = 2.0, 5
_SHOWN = """(before) => {
  const hello = gridbloom.connection.store.hello.peek();
  return hello && hello.session !== before && gridbloom.cells().free > 50;
}"""


def _once(browser: Browser, folder: Path) -> float:
    with serving(folder) as service, visiting(browser, service.address, reduced_motion="no-preference") as context:
        page = context.new_page()
        page.goto(f"{service.address}/lab.html")
        await_map(page)
        before = session_of(page)
        process = service.numbered()[int(before.partition(".")[0])]
        began = time.monotonic()
        os.kill(process, signal.SIGKILL)
        await_true(page, _SHOWN, before)
        return time.monotonic() - began


def killed(repetitions: int = REPETITIONS) -> None:
    """Print the times of so many services of two workers, one of which is killed."""
    print(f"load {os.getloadavg()[0]:.1f} before the run; at most {WANTED_S:g} s is wanted")
    with running_chromium() as browser, tempfile.TemporaryDirectory() as name:
        times = [_once(browser, Path(name) / str(n)) for n in range(repetitions)]
    said = ", ".join(f"{seconds:.2f}" for seconds in times)
    print(f"from the kill of a worker to the map of its lab page: {said} s; median {statistics.median(times):.2f} s")
