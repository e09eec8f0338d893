import { type Signal, signal, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { bytes } from "../../ui/numbers";
import { printing } from "../../ui/theme";
import { Stage } from "../common/Stage";
import { type Made, make, SCANS, SIDES, sizeOf } from "./model";
import "../common/lesson.css";
import "./resolution.css";

/** The maps are made once, one after the other, coarse ones first. */
const made: readonly Signal<Made | null>[] = SIDES.map(() => signal(null));

function makeNext(): boolean {
  const next = made.findLastIndex((one) => one.peek() === null);
  const [one, side] = [made[next], SIDES[next]];
  if (!one || side === undefined) return false;
  one.value = make(side);
  return true;
}

/** The door and the pillar in cells of 1, 5 and 10 cm, with the memory of the floor and the time of the update. */
export function Resolution() {
  useEffect(() => {
    let timer = setTimeout(next, 30);
    function next(): void {
      if (makeNext()) timer = setTimeout(next, 30);
    }
    return () => clearTimeout(timer);
  }, []);
  if (printing.value) while (makeNext());
  return (
    <figure class="resolution" aria-label="The same scans in cells of 1, 5 and 10 cm">
      <div class="side-by-side three">
        {SIDES.map((side, i) => (
          <Panel key={side} side={side} made={made[i]?.value ?? null} />
        ))}
      </div>
      <figcaption class="quiet">
        {SCANS} scans of 240 beams with a noise of σ = 1 cm. Memory: log-odds of 4 bytes for each cell of the whole
        floor. Time: the update by the program of the lecture, in this browser.
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
      <p class="quiet number">
        {cells.toLocaleString("en")} cells, <b>{bytes(size)}</b>
        <br />
        {now ? (
          <>
            <b>{now.ms < 10 ? now.ms.toFixed(1) : Math.round(now.ms)} ms</b> for {SCANS} scans
          </>
        ) : (
          "not yet measured"
        )}
      </p>
    </div>
  );
}

function Picture({ side, made: { grid } }: { readonly side: number; readonly made: Made }) {
  const shown = useSignal(grid);
  return (
    <Stage
      geometry={grid.geometry}
      label={`The door and the pillar in cells of ${Math.round(100 * side)} cm`}
      grid={shown}
    />
  );
}
