/** Legend of the colours of a difference. */

import { useEffect, useRef } from "preact/hooks";
import { differenceColour, differenceColours, spanOf, strengthOf } from "../../render/map/difference";
import { pictureColours } from "../../render/picture/pictureColours";
import { signed } from "../../ui/numbers";
import type { Comparison } from "./comparison";

const TICKS = [-2, -0.5, 0, 0.5, 2];

export function Legend({ comparison }: { readonly comparison: Comparison }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const pair = comparison.pair.value;
  const theme = pictureColours.value;
  useEffect(() => {
    const ctx = canvas.current?.getContext("2d");
    if (!ctx) return;
    const colours = differenceColours();
    for (let x = 0; x < 255; x++) {
      const along = (x - 127) / 127;
      ctx.fillStyle = `rgb(${differenceColour(Math.abs(along), along > 0, colours).join(" ")})`;
      ctx.fillRect(x, 0, 1, 1);
    }
  }, [theme]);
  const span = pair ? spanOf(pair.a.geometry, pair.b.geometry) : 5.5;
  const at = (difference: number): string =>
    `${(50 + 50 * Math.sign(difference) * strengthOf(difference, span)).toFixed(1)}%`;
  const ends = [-span, ...TICKS.filter((tick) => Math.abs(tick) < 0.5 * span), span];
  return (
    <div class="compare-legend">
      <span>Log-odds of B − A: blue is more free in B, orange more occupied</span>
      <canvas ref={canvas} class="compare-ramp" width={255} height={1} />
      <div class="compare-ticks" aria-hidden="true">
        {ends.map((tick) => (
          <span key={tick} style={{ left: at(tick) }}>
            {signed(tick, Number.isInteger(tick) ? 0 : 1)}
          </span>
        ))}
      </div>
      <ul class="compare-keys">
        <li>
          <span class="compare-swatch wall" aria-hidden="true" /> the same, occupied
        </li>
        <li>
          <span class="compare-swatch only-a" aria-hidden="true" /> known only in A
        </li>
        <li>
          <span class="compare-swatch only-b" aria-hidden="true" /> known only in B
        </li>
      </ul>
    </div>
  );
}
