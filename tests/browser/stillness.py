"""Whether what is in view on the lecture stays where it is while the figures around it are rendered.

The functions are JavaScript, for any browser. What is read is sampled after the layout of each frame and before it is
painted, when a browser or the page has put right what something above has moved.
"""

from __future__ import annotations

#: Most that anything in view may move, CSS pixels: positions are rounded to pixels of the screen.
STILL_WITHIN = 2

#: Keep the page from being idle, so that no figure far from the window is rendered, until :data:`LET_GO`.
HOLD = "() => { window.held = setInterval(() => dispatchEvent(new WheelEvent('wheel')), 10); }"
LET_GO = "() => clearInterval(window.held)"

#: The number of figures that are not rendered yet.
AWAITED = "() => document.querySelectorAll('.figure-awaited').length"

#: Given the id of a section: the distance from where it belongs in the window; null where there is no such section yet.
OFF = """id => {
  const section = document.getElementById(id);
  const padding = parseFloat(getComputedStyle(document.documentElement).scrollPaddingTop);
  return section && section.getBoundingClientRect().top - padding;
}"""

#: Follow an address within the page, and wait until it has been followed and painted.
JUMP = """async id => {
  location.hash = id;
  await new Promise(done => addEventListener("hashchange", done, { once: true }));
  await new Promise(requestAnimationFrame);
  await new Promise(done => setTimeout(done));
}"""

#: From now on keep what moves in view, and each rendered figure whose box changes its height.
WATCH = f"""() => {{
  window.stillness?.observer.disconnect();
  const inView = element => {{
    const {{ top, bottom, height }} = element.getBoundingClientRect();
    return height > 0 && bottom > 0 && top < innerHeight;
  }};
  const all = [...document.querySelectorAll(".lesson, .lesson > *, .prose > *, .lesson-figure > div")];
  const topOf = element => element.getBoundingClientRect().top;
  const heightOf = element => element.getBoundingClientRect().height;
  // Not the sections themselves: one may begin far above the window and grow there.
  const seen = new Map(all.filter(one => inView(one) && topOf(one) > -1).map(one => [one, topOf(one)]));
  const boxes = new Map();
  const found = new Map();
  const tell = (element, what, by) => {{
    if (Math.abs(by) <= {STILL_WITHIN}) return;
    const name = `${{element.closest(".lesson").id}}, ${{element.className || element.tagName}}`;
    found.set(element, `${{name}} ${{what}} ${{by}}`);
  }};
  const observer = new ResizeObserver(() => {{
    for (const [element, top] of seen) tell(element, "moved by", topOf(element) - top);
    for (const box of all.filter(one => one.matches(".lesson-figure > div:not(.figure-awaited)"))) {{
      if (boxes.has(box)) tell(box, "changed its height by", heightOf(box) - boxes.get(box));
      else boxes.set(box, heightOf(box));
    }}
  }});
  for (const element of all) observer.observe(element);
  window.stillness = {{ observer, found, seen: seen.size }};
}}"""

#: How many elements were in view, and what was found since :data:`WATCH`.
FOUND = "() => [window.stillness.seen, [...window.stillness.found.values()]]"
