/** The font of a figure's labels, for text on a canvas: drawings in SVG take the same size and family by their style. */
export function labelFont(): string {
  const probe = document.createElement("span");
  probe.hidden = true;
  probe.style.font = "var(--text-label) var(--font-ui)";
  document.body.append(probe);
  const { fontSize, fontFamily } = getComputedStyle(probe);
  probe.remove();
  return `${fontSize} ${fontFamily}`;
}
