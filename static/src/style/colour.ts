/** Token colours as numbers, for WebGL and canvas. */

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
