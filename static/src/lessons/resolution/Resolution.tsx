import { type Signal, signal, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { printing } from "../../ui/browser/theme";
import { bytes } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { Stage } from "../common/Stage";
import { onPath } from "../stage/path";
import { type Made, make, SCANS, SIDES, sizeOf } from "./model";
import "../common/lesson.css";
import "./resolution.css";

const FIRST_NOISE = 0.01;
const noise = onPath(FIRST_NOISE);
const made: readonly Signal<Made | null>[] = SIDES.map(() => signal(null));

/** Make the next map that is missing or has other noise, coarse ones first; return whether there was one. */
function makeNext(): boolean {
  const next = made.findLastIndex((noisyMap) => noisyMap.peek()?.noise !== noise.peek());
  const [map, side] = [made[next], SIDES[next]];
  if (!map || side === undefined) return false;
  map.value = make(side, noise.peek());
  return true;
}

/** The door and the pillar in cells of 1, 5 and 10 cm, with the memory of the floor and the number of updates. */
export function Resolution() {
  const sigma = noise.value;
  useEffect(() => {
    let timer = setTimeout(next, 30);
    function next(): void {
      if (makeNext()) timer = setTimeout(next, 30);
    }
    return () => clearTimeout(timer);
  }, [sigma]);
  if (printing.value) while (makeNext());
  return (
    <figure class="resolution" aria-label="The same scans in cells of 1, 5 and 10 cm">
      <div class="side-by-side three">
        {SIDES.map((side, i) => (
          <Panel key={side} side={side} made={made[i]?.value ?? null} />
        ))}
      </div>
      <div class="figure-controls no-print">
        <Slider
          label="Range noise σ"
          sentence="Standard deviation of the measured distances from which all three maps are made."
          value={sigma}
          initial={FIRST_NOISE}
          low={0}
          high={0.1}
          step={0.01}
          unit="m"
          tone="beam"
          onInput={(value) => {
            noise.value = value;
          }}
        />
      </div>
      <figcaption>
        {SCANS} scans of 240 beams. Memory: 4 bytes for each cell of the whole floor. Updates: cells of the part shown.
      </figcaption>
    </figure>
  );
}

function Panel({ side, made: now }: { readonly side: number; readonly made: Made | null }) {
  const { cells, bytes: size } = sizeOf(side);
  return (
    <div>
      <h3>{Math.round(100 * side)} cm</h3>
      {now ? <Picture side={side} made={now} /> : <p class="resolution-awaited">Making the map …</p>}
      <p class="number">
        {cells.toLocaleString("en")} cells, <b>{bytes(size)}</b>
        <br />
        <b class="awaited-number">{now ? now.updates.toLocaleString("en") : "…"}</b> updates by {SCANS} scans
      </p>
    </div>
  );
}

function Picture({ side, made }: { readonly side: number; readonly made: Made }) {
  const shown = useSignal(made.grid);
  shown.value = made.grid;
  return (
    <Stage
      geometry={made.grid.geometry}
      label={`The door and the pillar in cells of ${Math.round(100 * side)} cm`}
      grid={shown}
    />
  );
}
