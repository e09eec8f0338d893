"""The heights of the lecture's figures over the width of the window, which the page reserves until they are rendered.

As a script it measures them in Chromium and writes ``figureHeights.json``; run it when a figure's layout has changed:
``python -m tests.browser.figure_heights``.
"""

from __future__ import annotations

import json
import tempfile
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from playwright.sync_api import Page, expect

from tests.browser.running import running_chromium, running_server

FILE = Path(__file__).parents[2] / "static" / "src" / "pages" / "lecture" / "figureHeights.json"
NARROWEST, WIDEST, STEP = 320, 2560, 64  # of the window, CSS pixels; a figure is as wide as it can be before the widest
# Between two measured widths the height is the one of the line between them, within so many pixels.
MEASURED_WITHIN = 8.0
WITHIN = 24.0  # of the polyline that is written, pixels: a line of text

#: Of each section: the height of its figure, or null while it is awaited.
HEIGHTS = """() => Object.fromEntries([...document.querySelectorAll(".lesson")].map(section => {
  const place = section.querySelector(".lesson-figure > div");
  return [section.id, place.classList.contains("figure-awaited") ? null : place.offsetHeight];
}))"""
_SETTLED = """async () => {
  for (let before = -1, same = 0; same < 4; ) {
    await new Promise(requestAnimationFrame);
    const now = document.documentElement.scrollHeight;
    same = now === before ? same + 1 : 0;
    before = now;
  }
}"""

Heights = dict[str, int]


def measured_widths(measure: Callable[[int], Heights]) -> dict[int, Heights]:
    """Return the heights at so many widths that lines between neighbours are close enough, or 1 pixel wide."""
    at = {width: measure(width) for width in range(NARROWEST, WIDEST + 1, STEP)}
    open_ = list(zip(sorted(at), sorted(at)[1:], strict=False))
    while open_:
        low, high = open_.pop()
        if high - low < 2:
            continue
        middle = (low + high) // 2
        share = (middle - low) / (high - low)
        at[middle] = measure(middle)
        off = (abs(at[low][k] + share * (at[high][k] - at[low][k]) - at[middle][k]) for k in at[middle])
        if max(off) > MEASURED_WITHIN:
            open_ += [(low, middle), (middle, high)]
    return dict(sorted(at.items()))


def polyline(widths: list[int], heights: list[int]) -> list[tuple[int, int]]:
    """Return some of the points, between which lines are within the tolerance of all (Douglas and Peucker, 1973)."""
    line = np.interp(widths, [widths[0], widths[-1]], [heights[0], heights[-1]])
    off = np.abs(line - heights)
    worst = int(off.argmax())
    if off[worst] <= WITHIN:
        return [(widths[0], heights[0]), (widths[-1], heights[-1])]
    return polyline(widths[: worst + 1], heights[: worst + 1])[:-1] + polyline(widths[worst:], heights[worst:])


def measure_figures(page: Page, server: str) -> dict[str, list[tuple[int, int]]]:
    """Return the polyline of each figure's height over the width of the window."""
    page.goto(f"{server}/lecture.html")
    expect(page.locator(".figure-awaited")).to_have_count(0, timeout=120_000)

    @cache
    def measure(width: int) -> Heights:
        page.set_viewport_size({"width": width, "height": 900})
        page.evaluate(_SETTLED)
        heights: Heights = page.evaluate(HEIGHTS)
        return heights

    at = measured_widths(measure)
    return {name: polyline(list(at), [heights[name] for heights in at.values()]) for name in at[NARROWEST]}


def main() -> None:
    """Measure and write."""
    ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter).parse_args()
    with (
        tempfile.TemporaryDirectory() as data,
        running_server(Path(data)) as server,
        running_chromium() as browser,
    ):
        found = measure_figures(browser.new_page(), server)
    lines = [f"  {json.dumps(name)}: {json.dumps(points)}" for name, points in found.items()]
    FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n")
    print(f"{len(found)} figures, {sum(map(len, found.values()))} points")


if __name__ == "__main__":
    main()
