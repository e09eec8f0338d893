import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import { linePath } from "../../render/chart/scale";
import { Button } from "../../ui/Button";
import { written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { PlayButton } from "../common/PlayButton";
import { Plot } from "../common/Plot";
import { useSeen, useSteps } from "../common/useSteps";
import { advance, carry, elsewhere, INITIAL, type Moment, type Settings } from "./kidnap";
import { continueWalk, settings, walk, walkAgain } from "./state";
import "../../render/chart/chart.css";
import "./localization.css";

const MS_PER_SCAN = 250;
const HEIGHT = 190;
const PAD = { left: 34, right: 12, top: 26, bottom: 30 };
/** Scans in the chart. */
const SHOWN = 60;

/** What stands beside the kidnapped robot: its controls, and the averages of table 8.3. */
export function Kidnapping() {
  const root = useRef<HTMLDivElement>(null);
  const playing = useSignal(false);
  const scan = (): void => continueWalk((now) => advance(now, settings.peek()));
  useSteps(playing, useSeen(root), () => MS_PER_SCAN, scan);
  const { past } = walk.value;
  const last = past.at(-1);
  const set = (change: Partial<Settings>): void => {
    settings.value = { ...settings.peek(), ...change };
  };
  const { alphaSlow, alphaFast, particles } = settings.value;
  return (
    <div class="kidnapping stack-narrow" ref={root}>
      <Averages past={past} />
      <p class="legend">
        <Key tone="slow">slow average</Key>
        <Key tone="fast">fast average</Key>
        <Key tone="share">random particles</Key>
        <Key tone="near">belief at the robot</Key>
      </p>
      <div class="figure-controls no-print">
        <PlayButton playing={playing} play="Drive on" isPrimary />
        <Button icon="stepForward" label="One scan" onClick={scan} />
        <Button onClick={() => continueWalk((now) => carry(now, elsewhere(now)))}>Kidnap the robot</Button>
        <Button
          icon="restart"
          label="From the start"
          onClick={() => {
            playing.value = false;
            walkAgain();
          }}
        />
        <Slider
          label="Slow rate"
          sentence="Rate of the slow average of the weights; 0: it keeps its first value."
          value={alphaSlow}
          initial={INITIAL.alphaSlow}
          low={0}
          high={0.5}
          step={0.01}
          onInput={(value) => set({ alphaSlow: value })}
        />
        <Slider
          label="Fast rate"
          sentence="Rate of the fast average of the weights; with 0 in both there are no random particles."
          value={alphaFast}
          initial={INITIAL.alphaFast}
          low={0}
          high={1}
          step={0.01}
          onInput={(value) => set({ alphaFast: value })}
        />
        <Slider
          label="Particles"
          sentence="Number of particles."
          value={particles}
          initial={INITIAL.particles}
          low={100}
          high={2000}
          step={100}
          onInput={(value) => set({ particles: value })}
        />
      </div>
      <p class="number" aria-live={playing.value ? "off" : "polite"}>
        Scan {past.length}: slow average {written(last?.slow ?? 0, 3)}, fast average {written(last?.fast ?? 0, 3)}, so{" "}
        {written(100 * (last?.share ?? 0), 0)} % of the next particles are random.
      </p>
    </div>
  );
}

function Averages({ past }: { past: readonly Moment[] }) {
  const shown = past.slice(-SHOWN);
  const first = past.length - shown.length;
  return (
    <Plot
      height={HEIGHT}
      label="Averages of the weights, share of random particles and share of the belief at the robot"
    >
      {(width) => {
        const across = (width - PAD.left - PAD.right) / (SHOWN - 1);
        const [top, bottom] = [PAD.top, HEIGHT - PAD.bottom];
        const x = (i: number): number => PAD.left + i * across;
        const y = (p: number): number => bottom - p * (bottom - top);
        const line = (of: (moment: Moment) => number): string =>
          linePath(shown.map((moment, i) => [x(i), y(of(moment))]));
        return (
          <>
            {[0, 0.5, 1].map((p) => (
              <g key={p}>
                <path class="inverse-line" d={`M${x(0)} ${y(p)}H${width - PAD.right}`} />
                <text x={PAD.left - 6} y={y(p) + 4} text-anchor="end">
                  {p}
                </text>
              </g>
            ))}
            {shown.map(
              ({ kidnapped }, i) =>
                kidnapped && (
                  <g key={first + i}>
                    <path class="kidnapping-moment" d={`M${x(i)} ${top - 8}V${bottom}`} />
                    <text x={x(i) + 4} y={top - 10}>
                      carried away
                    </text>
                  </g>
                ),
            )}
            <path
              class="kidnapping-area"
              d={`${line(({ share }) => share)}L${x(shown.length - 1)} ${bottom}L${x(0)} ${bottom}Z`}
            />
            <path class="kidnapping-near" d={line(({ near }) => near)} />
            <path class="kidnapping-slow" d={line(({ slow }) => slow)} />
            <path class="kidnapping-fast" d={line(({ fast }) => fast)} />
            <text x={width - PAD.right} y={HEIGHT - 6} text-anchor="end">
              scans
            </text>
          </>
        );
      }}
    </Plot>
  );
}

function Key({ tone, children }: { tone: string; children: ComponentChildren }) {
  return (
    <span>
      <svg class="inverse-swatch" viewBox="0 0 36 8" aria-hidden="true">
        <path
          class={tone === "share" ? "kidnapping-area" : `kidnapping-${tone}`}
          d={tone === "share" ? "M0 0H36V8H0Z" : "M0 4H36"}
        />
      </svg>{" "}
      {children}
    </span>
  );
}
