"""Measurements of a slide: the size of its text on the screen, and elements that are cut off."""

from __future__ import annotations

from typing import Any

from playwright.sync_api import Page, expect

# Of each text on show its size in pixels of the screen. Indices and exponents are smaller by nature and left out.
_TEXTS = """() => {
  const found = [];
  const walker = document.createTreeWalker(document.querySelector("#app"), NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const text = node.textContent.trim(), parent = node.parentElement;
    if (!text || !parent.checkVisibility({ visibilityProperty: true, opacityProperty: true })) continue;
    if (parent.closest("sub, sup, desc, title, option, .visually-hidden, .tip, [baseline-shift]")) continue;
    const sized = parent.closest("math") ?? parent;
    const svg = parent.closest("svg");
    const matrix = svg && !parent.closest("foreignObject") ? parent.getScreenCTM() : null;
    const scale = matrix ? Math.hypot(matrix.a, matrix.b) : sized.currentCSSZoom;
    found.push([text.slice(0, 40), Math.round(10 * parseFloat(getComputedStyle(sized).fontSize) * scale) / 10]);
  }
  return found;
}"""

# Labels that are not within their drawing.
_OUT = """(within) => {
  const found = [];
  for (const svg of document.querySelectorAll(`${within} svg:not(.icon)`)) {
    if (!svg.checkVisibility({ visibilityProperty: true })) continue;
    const around = svg.getBoundingClientRect();
    for (const text of svg.querySelectorAll("text")) {
      const [box, matrix] = [text.getBoundingClientRect(), text.getScreenCTM()];
      const [left, right] = [around.left - box.left, box.right - around.right];
      const out = Math.max(left, right, around.top - box.top, box.bottom - around.bottom);
      // A letter is lower than the box of its line.
      const slack = 0.3 * parseFloat(getComputedStyle(text).fontSize) * Math.hypot(matrix.a, matrix.b);
      if (box.width > 0 && out > slack) found.push([text.textContent, "out of its drawing", Math.round(out)]);
    }
  }
  return found;
}"""

# What does not fit: the figure in its room, words in their box.
_CUT = """() => {
  const found = [];
  for (const box of document.querySelectorAll(".presenter, .lecture, .on-slide, .on-slide .lesson-room, .own-slide")) {
    if (!box.checkVisibility({ visibilityProperty: true })) continue;
    const [height, width] = [box.scrollHeight - box.clientHeight, box.scrollWidth - box.clientWidth];
    if (height > 1) found.push([box.className, "too high", height]);
    if (width > 1) found.push([box.className, "too wide", width]);
    const rect = box.getBoundingClientRect();
    if (rect.bottom > innerHeight + 1 || rect.right > innerWidth + 1) found.push([box.className, "off the screen"]);
  }
  for (const formula of document.querySelectorAll(".on-slide math")) {
    if (!formula.checkVisibility({ visibilityProperty: true })) continue;
    const content = document.createRange();
    content.selectNodeContents(formula);
    const out = content.getBoundingClientRect().right - formula.getBoundingClientRect().right;
    if (out > 1) found.push([formula.textContent.slice(0, 20), "out of its column", Math.round(out)]);
  }
  for (const box of document.querySelectorAll(".on-slide :not(svg *), .presenter *")) {
    if (!box.checkVisibility({ visibilityProperty: true }) || box.closest(".visually-hidden, math")) continue;
    const isCut = ["hidden", "clip"].includes(getComputedStyle(box).overflowX);
    if (isCut && box.scrollWidth > box.clientWidth + 2 && box.innerText?.trim())
      found.push([box.className || box.tagName, "cuts its text"]);
  }
  return found;
}"""


def small_texts(page: Page, least: float) -> list[Any]:
    """Return each text of the slide that is smaller than ``least`` pixels of the screen, with its size."""
    texts = page.evaluate(_TEXTS)
    assert texts
    return [text for text in texts if text[1] < least]


def cut_labels(page: Page, within: str) -> list[Any]:
    """Return the labels that are not within their drawing, of the drawings in what a selector finds."""
    return list(page.evaluate(_OUT, within))


def cut_off(page: Page) -> list[Any]:
    """Return what does not fit the slide."""
    return [*page.evaluate(_CUT), *cut_labels(page, ".on-slide")]


def settle(page: Page) -> None:
    """Wait until the slide is laid out: fonts are there, and figures have kept their size for some frames."""
    page.evaluate("document.fonts.ready.then(() => true)")
    page.evaluate("""async () => {
      for (let before = "", same = 0; same < 8; ) {
        await new Promise(requestAnimationFrame);
        const boxes = [...document.querySelectorAll(".on-slide .lesson-figure, .on-slide figure")];
        const now = boxes.map(box => box.offsetWidth + " " + box.offsetHeight).join();
        same = now === before ? same + 1 : 0;
        before = now;
      }
    }""")


def slide_ids(page: Page, server: str) -> list[str]:
    """Open the presentation; return the names of its slides, as addresses have them."""
    page.goto(f"{server}/lecture.html?present")
    expect(page.locator(".presenter-number")).to_contain_text("1 /")
    page.keyboard.press("Home")
    ids = [""]
    while True:
        name = page.evaluate("location.hash").removeprefix("#").split("/")[0]
        if name == ids[-1]:
            return ids[1:]
        ids.append(name)
        page.keyboard.press("Shift+ArrowRight")
