import { computed, type Signal, useSignal } from "@preact/signals";
import { useMemo, useRef } from "preact/hooks";
import { evidenceScale, LogOddsBackground, readingScale, ZoneNames } from "../../render/chart/LogOddsBackground";
import { linePath, toPixel } from "../../render/chart/scale";
import { Button } from "../../ui/Button";
import { bound } from "../../ui/bound";
import { reducedMotion } from "../../ui/browser/media";
import { Slider } from "../../ui/Slider";
import type { ClassQuestion } from "../../wire/protocol";
import { GuessColumns, type GuessQuestion, useClassGuess } from "../common/classGuess";
import { RobotShape } from "../common/DragHandle";
import { PlayButton } from "../common/PlayButton";
import { Plot } from "../common/Plot";
import { Scene, Walls } from "../common/Scene";
import { useSeen, useSteps } from "../common/useSteps";
import { type Clamp, GEOMETRY, type MapHistory, ROOM, SENSOR, simulateRemoval, TABLE } from "./model";
import "./forgetting.css";

const OFF: Clamp = { on: false, low: -2, high: 3.5 };
const MS_PER_SCAN = 70;
const MOST_SCANS = 120;
/** What a class is asked. */
const QUESTION: GuessQuestion = {
  text: "The table is taken away. After how many scans has the map with the clamp forgotten it?",
  axis: { low: 0, high: MOST_SCANS, unit: "scans" },
};

const scans = (count: number): string => `${count} scan${count === 1 ? "" : "s"}`;

interface ForgettingProps {
  /** Number of scans with the table. */
  readonly seen: Signal<number>;
  readonly clamp: Signal<Clamp>;
}

/**
 * The moving table: the reader guesses, the table is removed, and two maps show how many scans they need to forget it.
 */
export function Forgetting({ seen, clamp }: ForgettingProps) {
  const prediction = useSignal(20);
  /** Scans since the table was removed; null while it is there. */
  const since = useSignal<number | null>(null);
  const playing = useSignal(false);
  const root = useRef<HTMLElement>(null);
  const results = useMemo(
    () =>
      computed(() => {
        const limit = Math.ceil(2.6 * seen.value) + 30;
        return {
          limit,
          clamped: simulateRemoval(seen.value, limit, clamp.value),
          free: simulateRemoval(seen.value, limit, OFF),
        };
      }),
    [seen, clamp],
  );
  const { limit, clamped, free } = results.value;
  const end = Math.min(limit, Math.max(clamped.forgottenAfter ?? limit, free.forgottenAfter ?? limit) + 4);
  const t = since.value === null ? null : Math.min(since.value, end);
  const step = (by: number): void => {
    const next = Math.min(end, Math.max(0, (since.peek() ?? 0) + by));
    since.value = next;
    if (next >= end) playing.value = false;
  };
  const isInSight = useSeen(root);
  useSteps(
    playing,
    isInSight,
    () => MS_PER_SCAN,
    () => step(1),
  );
  const done = t !== null && t >= end;
  // The chart shows the answers where the lecturer sees it.
  const { asked, ask } = useClassGuess(QUESTION, done ? clamped.forgottenAfter : null, isInSight.value);
  return (
    <figure class="forgetting stack" ref={root} aria-label="A table is removed: the map with the clamp and without it">
      <div class="side-by-side">
        <Room name="with the clamp" line="clamped" history={clamped} seen={seen.value} t={t} />
        <Room name="without a clamp" line="free" history={free} seen={seen.value} t={t} />
      </div>
      <Plot height={HEIGHT + 22} label="Log-odds of the table’s last cell over the scans, with the clamp and without">
        {(width) => (
          <Chart
            width={width}
            seen={seen.value}
            t={t}
            end={end}
            clamped={clamped}
            free={free}
            prediction={prediction.value}
            asked={asked}
            clamp={clamp.value}
          />
        )}
      </Plot>
      <div class="figure-controls no-print">
        <Slider
          label="My guess"
          sentence="Your guess: after how many scans the map with the clamp has forgotten the table."
          {...bound(prediction)}
          initial={20}
          low={1}
          high={MOST_SCANS}
          step={1}
          unit="scans"
          disabled={t !== null}
        />
        {ask && t === null && (
          <Button icon="people" onClick={ask}>
            Ask the class
          </Button>
        )}
        {t === null ? (
          <Button
            kind="primary"
            onClick={() => {
              since.value = 0;
              playing.value = !reducedMotion.peek();
            }}
          >
            Remove the table
          </Button>
        ) : (
          <>
            {!done && <PlayButton playing={playing} play="Continue" />}
            <Button icon="stepBack" label="Back one scan" onClick={() => step(-1)} />
            <Button icon="stepForward" label="Forward one scan" onClick={() => step(1)} />
            {reducedMotion.value && !done && <Button onClick={() => step(end)}>To the end</Button>}
            <Button
              icon="restart"
              onClick={() => {
                playing.value = false;
                since.value = null;
              }}
            >
              Put the table back
            </Button>
          </>
        )}
      </div>
      <figcaption aria-live={playing.value ? "off" : "polite"}>
        {t === null ? (
          <>The table was seen in {scans(seen.value)}. How many scans does the map need to forget it?</>
        ) : (
          <>
            {scans(t)} since it was removed. Your guess: <b class="noun-robot">{prediction.value}</b>. With the clamp:{" "}
            <Outcome history={clamped} t={t} />; without it: <Outcome history={free} t={t} />.
            {done && clamped.forgottenAfter !== null && (
              <Verdict guess={prediction.value} was={clamped.forgottenAfter} />
            )}
          </>
        )}
      </figcaption>
    </figure>
  );
}

function Outcome({ history, t }: { history: MapHistory; t: number }) {
  const after = history.forgottenAfter;
  if (after === null || t < after) return <span>not yet forgotten</span>;
  return (
    <span>
      forgotten after <b>{after}</b>
    </span>
  );
}

function Verdict({ guess, was }: { guess: number; was: number }) {
  const off = guess - was;
  if (off === 0) return <> Exactly right.</>;
  return (
    <>
      {" "}
      Your guess was {Math.abs(off)} too {off > 0 ? "high" : "low"}.
    </>
  );
}

interface RoomProps {
  readonly name: string;
  /** Its line in the chart. */
  readonly line: "clamped" | "free";
  readonly history: MapHistory;
  readonly seen: number;
  readonly t: number | null;
}

function Room({ name, line, history, seen, t }: RoomProps) {
  const shown = useSignal(history.mapAfter(0));
  shown.value = history.mapAfter(seen + (t ?? 0));
  return (
    <div>
      <h3>
        {name}{" "}
        <svg class="forgetting-key" viewBox="0 0 36 6" aria-hidden="true">
          <path class={`forgetting-line ${line}`} d="M0 3H36" />
        </svg>
      </h3>
      <Scene geometry={GEOMETRY} label={`The map ${name}`} grid={shown} walls={ROOM}>
        {(transform) => (
          <>
            <Walls transform={transform} walls={TABLE} tone={t === null ? "wall" : "wall gone"} />
            <g transform={`translate(${transform.x(SENSOR[0])} ${transform.y(SENSOR[1])})`}>
              <RobotShape yaw={0} size={9} />
            </g>
          </>
        )}
      </Scene>
    </div>
  );
}

const HEIGHT = 200;

interface ChartProps {
  readonly width: number;
  readonly seen: number;
  readonly t: number | null;
  readonly end: number;
  readonly clamped: MapHistory;
  readonly free: MapHistory;
  readonly prediction: number;
  /** The question to the class; null if it was not asked. */
  readonly asked: ClassQuestion | null;
  readonly clamp: Clamp;
}

/** ℓ of the cell that is forgotten last, in both maps, over the scans. */
function Chart({ width, seen, t, end, clamped, free, prediction, asked, clamp }: ChartProps) {
  const now = seen + (t ?? 0);
  const across = readingScale(width, 0, seen + Math.max(end, prediction, asked ? MOST_SCANS : 0) + 2);
  const up = evidenceScale(HEIGHT, [clamp.low, clamp.high], free.path.slice(0, seen + 1));
  const x = (i: number): number => toPixel(i, across);
  const y = (l: number): number => toPixel(l, up);
  const line = (history: MapHistory): string => linePath(history.path.slice(0, now + 1).map((l, i) => [x(i), y(l)]));
  const guess = x(seen + prediction);
  return (
    <>
      <LogOddsBackground width={width} evidence={up} limits={[clamp.low, clamp.high]} />
      {asked && <GuessColumns asked={asked} x={(after) => x(seen + after)} foot={HEIGHT} height={0.6 * HEIGHT} />}
      <line class="forgetting-gone" x1={x(seen)} x2={x(seen)} y1={8} y2={HEIGHT - 8} />
      <line class="forgetting-guess" x1={guess} x2={guess} y1={8} y2={HEIGHT - 8} />
      <text class="guess" x={guess + 5} y={22}>
        your guess
      </text>
      <path class="forgetting-line free" d={line(free)} />
      <path class="forgetting-line clamped" d={line(clamped)} />
      <ZoneNames width={width} evidence={up} />
      {[clamped, free].map(
        (history, i) =>
          history.forgottenAfter !== null &&
          t !== null &&
          t >= history.forgottenAfter && (
            <circle
              key={["clamped", "free"][i]}
              class={`forgetting-dot ${["clamped", "free"][i]}`}
              cx={x(seen + history.forgottenAfter)}
              cy={y(history.path[seen + history.forgottenAfter] ?? 0)}
              r={6}
            />
          ),
      )}
      <text x={(x(0) + x(seen)) / 2} y={HEIGHT + 14} text-anchor="middle">
        with the table
      </text>
      <text x={x(seen) + 8} y={HEIGHT + 14}>
        {t === null ? "after its removal" : "without it"}
      </text>
    </>
  );
}
