"""The map drawn with WebGL and without: both pictures are equal."""

from __future__ import annotations

import math
from typing import Literal

import pytest
from playwright.sync_api import Browser, BrowserContext, Page

from tests.browser.conftest import standing_world
from tests.browser.looking import await_map, frame, painted, settled_digest, until
from tests.browser.visits import visiting

# Chromium without a graphics card names SwiftShader as its card, which the pages know: here they do not.
CARD = """(() => {
  const { getParameter } = WebGL2RenderingContext.prototype;
  const UNMASKED_RENDERER_WEBGL = 0x9246;
  WebGL2RenderingContext.prototype.getParameter = function (name) {
    return name === UNMASKED_RENDERER_WEBGL ? "a graphics card" : getParameter.call(this, name);
  };
})()"""
DRAWN_BY_CARD = "() => document.querySelector('.picture > canvas').getContext('2d') === null"

# Every 41st pixel of the belief, freshly painted: 41 goes into no width, so that all columns are met.
COLOURS = """() => {
  const view = gridbloom.connection.store.view.peek();
  gridbloom.colourAt([view.x, view.y]);
  const canvas = document.querySelectorAll(".picture > canvas")[1];
  const copy = document.createElement("canvas");
  copy.width = canvas.width;
  copy.height = canvas.height;
  const context = copy.getContext("2d");
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
  const colours = [];
  for (let at = 0; at < data.length; at += 4 * 41) colours.push([data[at], data[at + 1], data[at + 2]]);
  return colours;
}"""


def lab(context: BrowserContext, address: str, *, card: bool) -> Page:
    """Return the lab at an address, as it is drawn with or without a graphics card."""
    page = context.new_page()
    if card:
        page.add_init_script(CARD)
    page.goto(address)
    await_map(page)
    assert page.evaluate(DRAWN_BY_CARD) is card
    return page


@pytest.mark.parametrize("context", ["laptop"], indirect=True)
def test_card_and_processor_draw_the_same(context: BrowserContext, browser: Browser, server: str) -> None:
    """Cells, robot, beams and background have the same colours everywhere, in both themes, near and from afar."""
    plain = lab(context, f"{server}/lab.html?session={standing_world(context, server)}", card=False)
    index = frame(plain)["index"]
    plain.evaluate("() => gridbloom.connection.store.send({ type: 'step', scans: 5 })")  # cells glow, and fade
    until("some scans more", lambda: frame(plain)["index"] == index + 5)
    with visiting(browser, server, viewport=plain.viewport_size) as other:
        drawn = lab(other, plain.url, card=True)
        assert settled_digest(drawn) == settled_digest(plain)
        looks: list[tuple[str, str, Literal["light", "dark"]]] = [
            ("whole", "0", "light"),
            ("dark", "0", "dark"),
            ("near", "++++", "dark"),
            ("far", "0-----", "dark"),
        ]
        for what, keys, scheme in looks:
            colours = []
            for page in (plain, drawn):
                page.emulate_media(color_scheme=scheme)
                page.locator(".picture").nth(1).focus()
                for key in keys:
                    page.keyboard.press(key)
                painted(page)
                colours.append(page.evaluate(COLOURS))
            assert len({tuple(colour) for colour in colours[0]}) > 5, what
            # Where an edge goes through the middle of a pixel the two may round to either side.
            same = sum(math.dist(one, other) <= 12 for one, other in zip(*colours, strict=True))
            assert same >= 0.99 * len(colours[0]), f"{what}: {same} of {len(colours[0])} pixels are alike"
