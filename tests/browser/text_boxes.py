"""Measures where the text of a page is drawn: text that a control covers, and text that is cut off.

What is measured are the client rectangles of the text nodes, as https://www.w3.org/TR/cssom-view-1/#extension-to-the-range-interface
has them, against the bounding boxes of controls and of the ancestors that clip. Text that is scrolled out of view is
looked at where it is; text for screen readers only, and text that ends in an ellipsis, is left out.
"""

from __future__ import annotations

from playwright.sync_api import Page

# Lengths in CSS px. A line's rectangle is as high as the font's ascent and descent, more than what is drawn of most
# letters: what is missing at its top and bottom is counted from a fifth of its height on.
_WRONG = """(within) => {
  const SLACK = 1.5;
  const HANDLE = 22;  // height of a range's handle, in the middle of a higher box that takes touches
  const CONTROLS = "input, select, textarea, button, progress, [role=slider], [role=switch], [role=tab]";
  const LABELS = "label, legend, button, dt, th, [role=tab]";
  const DRAWN = "svg, [role=img], option, script, style";  // otherwise than as text, or not at all
  const styles = new Map();
  const styleOf = (one) => styles.get(one) ?? styles.set(one, getComputedStyle(one)).get(one);
  const isSeen = (one) => one.checkVisibility({ opacityProperty: true, visibilityProperty: true });
  const clips = (value) => value === "hidden" || value === "clip";
  const boxOf = (one) => {  // the padding box, in which its content is shown
    const { x, y } = one.getBoundingClientRect();
    return { left: x + one.clientLeft, top: y + one.clientTop,
             right: x + one.clientLeft + one.clientWidth, bottom: y + one.clientTop + one.clientHeight };
  };
  const overlap = (a, b) => [
    Math.min(a.right, b.right) - Math.max(a.left, b.left),
    Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top),
  ];
  const cutBy = (one, rect, slackY) => {
    const style = styleOf(one);
    const box = boxOf(one);
    if (clips(style.overflowX) && style.textOverflow !== "ellipsis")
      if (rect.left < box.left - SLACK || rect.right > box.right + SLACK) return true;
    return clips(style.overflowY) && style.webkitLineClamp === "none"
      && (rect.top < box.top - slackY || rect.bottom > box.bottom + slackY);
  };
  const shownIn = (one, { left, top, right, bottom }) => {  // the overflow of the body is the viewport's
    if (one === document.body || one === document.documentElement || styleOf(one).overflowX === "visible")
      return { left, top, right, bottom };
    const box = boxOf(one);
    return { left: Math.max(left, box.left), top: Math.max(top, box.top),
             right: Math.min(right, box.right), bottom: Math.min(bottom, box.bottom) };
  };
  // Of each text node that is seen: its rectangles where no scrolled box hides them, and what cuts them off.
  const found = [];
  const texts = [];
  for (const root of document.querySelectorAll(within)) {
    const walker = document.createTreeWalker(root, NodeFilter.SHOW_TEXT);
    for (let node = walker.nextNode(); node; node = walker.nextNode()) {
      const parent = node.parentElement;
      if (!node.data.trim() || !parent || parent.closest(DRAWN) || !isSeen(parent)) continue;
      const ancestors = [];
      for (let one = parent; one; one = one.parentElement) ancestors.push(one);
      const isForScreenReaders = ancestors.some((one) => {
        const { width, height } = one.getBoundingClientRect();
        return width < 2 && height < 2 && clips(styleOf(one).overflowX);
      });
      if (isForScreenReaders) continue;
      const label = parent.closest(LABELS);
      // A badge is over the corner of its tab, and between the words of two tabs.
      const isBadge = label && ancestors.slice(0, ancestors.indexOf(label)).some(
        (one) => styleOf(one).position === "absolute");
      const range = document.createRange();
      range.selectNodeContents(node);
      for (const { left, top, right, bottom } of range.getClientRects()) {
        if (right - left < 1) continue;
        const slackY = Math.max(SLACK, 0.2 * (bottom - top));
        let shown = { left, top, right, bottom };
        for (const one of ancestors) {
          if (cutBy(one, shown, slackY)) {
            found.push(["is cut off by", node, one]);
            break;
          }
          shown = shownIn(one, shown);
          if (shown.right <= shown.left || shown.bottom <= shown.top) break;
        }
        if (label && !isBadge && styleOf(label).display !== "inline") {
          const box = label.getBoundingClientRect();
          if (left < box.left - SLACK || right > box.right + SLACK) found.push(["is wider than", node, label]);
        }
        if (shown.right - shown.left > SLACK && shown.bottom - shown.top > slackY)
          if (!isBadge) texts.push([node, shown, slackY]);
      }
    }
  }
  // What sticks or is fixed lies over what is scrolled below it.
  const floats = (one) => one && (/sticky|fixed/.test(styleOf(one).position) ? one : floats(one.parentElement));
  const controls = [...document.querySelectorAll(CONTROLS)].filter(isSeen).map((one) => {
    const { left, top, right, bottom } = one.getBoundingClientRect();
    const rest = one.type === "range" ? Math.max(0, (bottom - top - HANDLE) / 2) : 0;
    let box = { left, top: top + rest, right, bottom: bottom - rest };
    for (let over = one.parentElement; over; over = over.parentElement) box = shownIn(over, box);
    return [one, box];
  });
  for (const [node, rect, slackY] of texts)
    for (const [control, box] of controls) {
      if (control.contains(node)) continue;
      const [wide, high] = overlap(rect, box);
      if (wide > SLACK && high > slackY && floats(node.parentElement) === floats(control))
        found.push(["is under or over", node, control]);
    }
  const tagOf = (one) => one.outerHTML.replace(one.innerHTML || "\\0", "…").slice(0, 160);
  return [...new Set(found.map(([what, node, one]) => `"${node.data.trim().slice(0, 60)}" ${what} ${tagOf(one)}`))];
}"""


def hidden_texts(page: Page, within: str) -> list[str]:
    """Return what is wrong with the text in the parts of the page that a selector finds, a sentence each."""
    found: list[str] = page.evaluate(_WRONG, within)
    return found
