/** Token colours as numbers, for WebGL and canvas. */

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

export type Rgb = readonly [red: number, green: number, blue: number];

let probe: HTMLElement | undefined;

/** Resolve a colour token (`--hit`) to bytes 0…255 in the current theme. An unknown token is read as black. */
export function tokenRgb(token: `--${string}`): Rgb {
  if (!probe) {
    probe = document.createElement("span");
    probe.hidden = true;
    document.body.append(probe);
  }
  probe.style.color = "";
  probe.style.color = `var(${token})`;
  const parts = getComputedStyle(probe).color.match(/[\d.]+/g) ?? [];
  return [Number(parts[0] ?? 0), Number(parts[1] ?? 0), Number(parts[2] ?? 0)];
}
