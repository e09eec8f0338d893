/**
 * Scroll what scrolls around an element up or down until the element is in sight. `scrollIntoView` would also scroll what
 * is around that: on a phone the stage, whose views are beside each other.
 */
export function scrollWithin(element: Element): void {
  for (let around = element.parentElement; around && around !== document.body; around = around.parentElement) {
    if (!/auto|scroll/.test(getComputedStyle(around).overflowY)) continue;
    const [own, whole] = [element.getBoundingClientRect(), around.getBoundingClientRect()];
    const style = getComputedStyle(element);
    const above = whole.top + Number.parseFloat(style.scrollMarginTop) - own.top;
    const below = own.bottom + Number.parseFloat(style.scrollMarginBottom) - whole.bottom;
    if (above > 0) around.scrollTop -= above;
    else if (below > 0) around.scrollTop += below;
    return;
  }
  element.scrollIntoView({ block: "nearest" });
}
