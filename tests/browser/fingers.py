"""Fingers on a touch screen, as Chromium's own touch events."""

from __future__ import annotations

from collections.abc import Callable

from playwright.sync_api import Page

Place = tuple[float, float]


class Fingers:
    """Fingers on the glass, one for each place."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self._session = page.context.new_cdp_session(page)

    def _touch(self, kind: str, *places: Place) -> None:
        points = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)]
        self._session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def drag(
        self, *ways: tuple[Place, Place], steps: int = 12, before_lifting: Callable[[], object] = lambda: None
    ) -> None:
        """Put one finger down for each way, move them all along, and lift them."""
        self._touch("touchStart", *(start for start, _ in ways))
        for i in range(1, steps + 1):
            part = i / steps
            places = [(x0 + (x1 - x0) * part, y0 + (y1 - y0) * part) for (x0, y0), (x1, y1) in ways]
            self._touch("touchMove", *places)
            self.page.evaluate("() => new Promise(requestAnimationFrame)")
        before_lifting()
        self._touch("touchEnd")
