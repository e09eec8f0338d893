/** The moving table: the visitor guesses how many scans the map needs to forget a table that is removed. */

import { useSignal, useSignalEffect } from "@preact/signals";
import { useRef } from "preact/hooks";
import { along } from "../../grid/beams";
import { type CellParameters, INITIAL_PARAMETERS, readingsUntil } from "../../grid/sensorModel";
import { FREE } from "../../render/chart/LogOddsBackground";
import { linePath, ticks } from "../../render/chart/scale";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { reducedMotion } from "../../ui/browser/media";
import { useDrawing } from "../../ui/browser/useDrawing";
import { written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { toast } from "../../ui/Toast";
import type { DrawnSolid, Forgetting, Frame, Values } from "../../wire/protocol";
import type { Comparison } from "../compare/comparison";
import { SecondMapChoice } from "../compare/SecondMap";
import "./table.css";

/** Side of the table and distances of its centre from the robot, metres. */
const SIDE = 0.6;
const DISTANCES = [1.6, 1.3, 1.0];
/** Free space behind the table, so that beams pass through its cells once it is removed, metres. */
const BEHIND = 0.3;
const BEARINGS = 36;

/** A table in front of the robot in free space of the newest scan, as close to straight ahead as possible; or null. */
export function placeOf(frame: Frame): DrawnSolid | null {
  const bearings = Array.from(
    { length: BEARINGS },
    (_, i) => ((i + 1) >> 1) * (i % 2 ? -1 : 1) * ((2 * Math.PI) / BEARINGS),
  );
  for (const distance of DISTANCES) {
    for (const bearing of bearings) {
      if (!isOpen(frame, bearing, distance)) continue;
      const [x, y] = along(frame.scan_pose, bearing, distance);
      const corner = (at: number, half: number): number => Math.round((at + half) * 20) * 5;
      const half = SIDE / 2;
      return ["box", corner(x, -half), corner(y, -half), corner(x, half), corner(y, half)];
    }
  }
  return null;
}

/** Whether every beam that could hit the table, in any of its orientations, has a range beyond it. */
function isOpen(frame: Frame, bearing: number, distance: number): boolean {
  const radius = (SIDE / 2) * Math.SQRT2;
  const half = Math.asin(Math.min(1, (radius + 0.1) / distance));
  let beams = 0;
  for (const [i, range] of frame.ranges.entries()) {
    const off = frame.angle_min + i * frame.angle_increment - bearing;
    if (Math.abs(Math.atan2(Math.sin(off), Math.cos(off))) > half) continue;
    if (range === null || range < distance + radius + BEHIND) return false;
    beams++;
  }
  return beams >= 4;
}

/**
 * Number of misses until a cell at the upper clamp is free. Null if it never becomes free, or if the model does not add
 * log-odds.
 */
export function passesToForget(values: Values): number | null {
  const limits = { log_odds_min: -2, log_odds_max: 3.5 };
  const config: CellParameters = {
    ...INITIAL_PARAMETERS,
    ...limits,
    ...(values as Partial<CellParameters>),
    clamp: true,
  };
  const isSum = config.model !== "moravec_elfes" && config.model !== "hit_counting";
  return isSum ? readingsUntil("miss", config.log_odds_max, FREE, config) : null;
}

/** Why the map without the clamp needs more scans, or fewer. */
export const withoutClamp = (clamped: number, free: number | null): string =>
  free !== null && free < clamped
    ? "Without the clamp it was faster this time: before the table was added, the cells had been observed as free for so long that they hardly became occupied."
    : "Without the clamp, the misses must outweigh all the hits that the table has added.";

export interface Point {
  readonly scans: number;
  readonly withClamp: number;
  readonly without: number;
}

/** The points so far, one for each scan; a new experiment starts a new list. */
export function grown(points: readonly Point[], message: Forgetting): readonly Point[] {
  const last = points.at(-1);
  const point = { scans: message.scans, withClamp: message.free_with_clamp, without: message.free_without_clamp };
  if (message.scans === 0) return [];
  // Both maps have forgotten everything: no more points.
  if (last && last.withClamp >= 1 && last.without >= 1 && message.scans > last.scans) return points;
  if (!last || message.scans > last.scans) return [...points, point];
  return message.scans < last.scans ? [point] : points;
}

/** The quality of a guess in words. */
export function verdict(guess: number, outcome: number): string {
  if (Math.abs(guess - outcome) <= Math.max(2, 0.2 * outcome)) return "You were right.";
  const ratio = Math.max(guess / outcome, outcome / guess);
  const times = Math.round(ratio);
  if (guess < outcome)
    return ratio < 2 ? "It took longer than you thought." : `It took ${times} times as long as you thought.`;
  return ratio < 2 ? "It was quicker than you thought." : `It was ${times} times as quick as you thought.`;
}

const HEIGHT = 184;
const LEFT = 58;
const RIGHT = 12;
const BOTTOM = HEIGHT - 40;
const TOP = 18;
/** Share of the table's cells that must be free, as counted by the mapper. */
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

/** The state of forgetting a removed object; null if none is measured. */
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
