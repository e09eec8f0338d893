/** The moving table: the visitor guesses how many scans the map needs to forget a table that is removed. */

import { useSignal, useSignalEffect } from "@preact/signals";
import { useRef } from "preact/hooks";
import { linePath, ticks } from "../../render/chart/scale";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { reducedMotion } from "../../ui/browser/media";
import { useDrawing } from "../../ui/browser/useDrawing";
import { written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { toast } from "../../ui/Toast";
import type { Forgetting } from "../../wire/protocol";
import type { Comparison } from "../compare/comparison";
import { SecondMapChoice } from "../compare/SecondMap";
import { grown, type Point, passesToForget, placeOf, verdict, withoutClamp } from "./model";
import "./table.css";

const HEIGHT = 184;
const LEFT = 58;
const RIGHT = 12;
const BOTTOM = HEIGHT - 40;
const TOP = 18;
/** Share of the table's cells that have to be free, as the mapper counts it. */
const FORGOTTEN = 0.9;
const TICK_PX = 80;

interface ForgettingChartProps {
  readonly points: readonly Point[];
  readonly guess: number;
  readonly forgetting: Forgetting | null;
}

/** The share of the table's cells that are free in each map, over the scans since its removal; the guess as a line. */
function ForgettingChart({ points, guess, forgetting }: ForgettingChartProps) {
  const box = useRef<HTMLDivElement>(null);
  const { width, scale } = useDrawing(box, 560).value;
  const right = width - RIGHT;
  const last = points.at(-1)?.scans ?? 0;
  const most = Math.max(20, guess * 1.15, last * 1.05, (forgetting?.without_clamp ?? 0) * 1.15);
  const x = (scans: number): number => LEFT + (scans / most) * (right - LEFT);
  const y = (share: number): number => BOTTOM - share * (BOTTOM - TOP);
  const path = (share: (point: Point) => number): string =>
    linePath(points.map((point) => [x(point.scans), y(share(point))]));
  return (
    <div class="table-chart" ref={box} style={{ height: `${scale * HEIGHT}px` }}>
      <svg
        class="drawing"
        style={{ zoom: scale }}
        width={width}
        height={HEIGHT}
        role="img"
        aria-label="Share of the table’s cells that are free, over the scans since it was removed"
      >
        {[0, 0.5, 1].map((share) => (
          <g key={share} class="tick">
            <line x1={LEFT} x2={right} y1={y(share)} y2={y(share)} />
            <text x={LEFT - 6} y={y(share) + 4} text-anchor="end">
              {share * 100} %
            </text>
          </g>
        ))}
        <line class="most" x1={LEFT} x2={right} y1={y(FORGOTTEN)} y2={y(FORGOTTEN)} />
        <text x={LEFT + 20} y={y(FORGOTTEN) + 14}>
          forgotten: {100 * FORGOTTEN} % free
        </text>
        {ticks(0, most, width / TICK_PX).map((tick) => (
          <text key={tick} class="tick" x={x(tick)} y={BOTTOM + 17} text-anchor="middle">
            {tick}
          </text>
        ))}
        <text x={(LEFT + right) / 2} y={HEIGHT - 6} text-anchor="middle">
          scans since the table was removed
        </text>
        <text transform={`translate(12 ${(TOP + BOTTOM) / 2}) rotate(-90)`} text-anchor="middle">
          its cells that are free
        </text>
        <line class="guess" x1={x(guess)} x2={x(guess)} y1={TOP - 6} y2={BOTTOM} />
        <path class="free" d={path((point) => point.without)} />
        <path class="clamped" d={path((point) => point.withClamp)} />
      </svg>
    </div>
  );
}

/** Least number of scans with the table before it can be removed. */
const LEAST_SCANS = 20;
const FIRST_GUESS = 40;
const FAST = 4;

type Stage = "idle" | "standing" | "gone";

interface MovingTableProps {
  readonly store: Store;
  readonly comparison: Comparison;
}

/** How far the maps have forgotten a removed object; null while this is not measured. */
const watched = (message: Forgetting | null): Forgetting | null => (message && message.cells > 0 ? message : null);

export function MovingTable({ store, comparison }: MovingTableProps) {
  const stage = useSignal<Stage>("idle");
  const since = useSignal(0);
  const guess = useSignal<number | null>(null);
  const points = useSignal<readonly Point[]>([]);
  const message = store.part("forgetting").message;
  const forgetting = watched(message.value);

  useSignalEffect(() => {
    const news = watched(message.value);
    if (news) points.value = grown(points.peek(), news);
    else if (stage.peek() === "gone" && points.peek().length > 0) stage.value = "idle";
    // The long wait for the map without the clamp is played faster.
    if (news?.with_clamp && !news.without_clamp && store.speed.peek() === 1) store.send({ type: "speed", value: FAST });
    if (news?.without_clamp && store.speed.peek() === FAST) store.send({ type: "speed", value: 1 });
  });

  // With reduced motion the session is paused and advances by 20 scans at a time.
  const goOn = (): void => {
    store.send(reducedMotion.peek() ? { type: "step", scans: LEAST_SCANS } : { type: "play" });
  };
  const setUp = (): void => {
    const frame = store.frame.peek();
    const edits = store.world.peek()?.edits;
    const table = frame && placeOf(frame);
    if (!edits || !table) {
      toast("There is no room for a table here. Move the robot to an open place.");
      return;
    }
    store.send({ type: "auto", value: false });
    store.edit({ added: [...edits.added, table], erased: edits.erased });
    goOn();
    since.value = frame.index;
    guess.value = null;
    points.value = [];
    stage.value = "standing";
  };
  const removeTable = (): void => {
    const edits = store.world.peek()?.edits;
    if (!edits) return;
    store.edit({ added: edits.added.slice(0, -1), erased: edits.erased }, true);
    goOn();
    stage.value = "gone";
  };
  const finish = (): void => {
    store.send({ type: "compare", values: null });
    store.send({ type: "auto", value: true });
    points.value = [];
    stage.value = "idle";
  };

  if (stage.value === "idle") {
    return (
      <div class="table-figure">
        <p>
          A table stands in front of the robot for a while and is then removed. After how many scans has it disappeared
          from the map?
        </p>
        <Button icon="box" disabled={!store.isReady.value} onClick={setUp}>
          Add a table
        </Button>
      </div>
    );
  }
  if (stage.value === "standing") {
    return (
      <Standing
        store={store}
        since={since.value}
        guess={guess.value}
        onGuess={(n) => {
          guess.value = n;
        }}
        onRemove={removeTable}
      />
    );
  }
  return (
    <div class="table-figure">
      <ForgettingChart points={points.value} guess={guess.value ?? 0} forgetting={forgetting} />
      <Outcome store={store} forgetting={forgetting} guess={guess.value ?? 0} />
      <SecondMapChoice store={store} comparison={comparison} />
      {reducedMotion.value && !forgetting?.without_clamp && (
        <Button icon="stepForward" onClick={goOn}>
          Forward {LEAST_SCANS} scans
        </Button>
      )}
      <Button onClick={finish}>{forgetting?.without_clamp ? "Continue" : "Stop and continue"}</Button>
    </div>
  );
}

interface StandingProps {
  readonly store: Store;
  readonly since: number;
  readonly guess: number | null;
  readonly onGuess: (guess: number) => void;
  readonly onRemove: () => void;
}

function Standing({ store, since, guess, onGuess, onRemove }: StandingProps) {
  const seen = Math.max(0, (store.frame.value?.index ?? since) - since);
  return (
    <div class="table-figure">
      <p>
        The table was seen in{" "}
        <output aria-live="off" class="number">
          {seen}
        </output>{" "}
        scans. Guess: after how many scans without the table will nine in ten of its cells be free?
      </p>
      <Slider
        label="My guess"
        sentence="Number of scans without the table after which nine in ten of its cells are free, with the clamp."
        unit="scans"
        value={guess ?? FIRST_GUESS}
        initial={FIRST_GUESS}
        low={1}
        high={200}
        step={1}
        tone="accent"
        onInput={onGuess}
      />
      <Button kind="primary" disabled={guess === null || seen < LEAST_SCANS} onClick={onRemove}>
        Remove the table
      </Button>
      {guess === null && <p class="table-note">Move the slider to make a guess first.</p>}
    </div>
  );
}

function Outcome({
  store,
  forgetting,
  guess,
}: {
  readonly store: Store;
  readonly forgetting: Forgetting | null;
  readonly guess: number;
}) {
  const values = store.mapping.values.value;
  const { with_clamp: clamped, without_clamp: free } = forgetting ?? { with_clamp: null, without_clamp: null };
  const passes = passesToForget(values);
  return (
    <div class="table-outcome stack-tight" role="status">
      <p>
        <span class="key guess" /> Your guess: <b>{guess}</b> scans. <span class="key clamped" /> With the clamp:{" "}
        <b>{clamped ?? "not yet"}</b>. <span class="key free" /> Without: <b>{free ?? "not yet"}</b>.
      </p>
      {clamped !== null && (
        <p>
          {verdict(guess, clamped)}{" "}
          {passes !== null &&
            `Clamped at ${written(Number(values.log_odds_max), 1)}, a cell is free after ${passes} ${
              values.update === "per_scan" ? "scans" : "beams"
            } have passed through it, however long it was seen. `}
          {withoutClamp(clamped, free)}
        </p>
      )}
    </div>
  );
}
