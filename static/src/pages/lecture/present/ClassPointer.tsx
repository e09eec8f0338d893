import { shownPointer } from "./classSlides";

/** The lecturer's pointer on a follower's slide. */
export function ClassPointer() {
  const at = shownPointer.value;
  const box = at && document.querySelector(".slides > main")?.getBoundingClientRect();
  if (!at || !box) return null;
  // The position is in the zoomed pixels of the slide: the element is within the zoomed page.
  const zoom = Number(document.documentElement.style.zoom) || 1;
  const [left, top] = [(box.x + at[0] * box.width) / zoom, (box.y + at[1] * box.height) / zoom];
  return <div class="class-pointer" aria-hidden="true" style={`left: ${left}px; top: ${top}px`} />;
}
