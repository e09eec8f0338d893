import { computed, type Signal, useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import { logOdds } from "../../grid/cellValues";
import { signed, written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { Plot } from "../common/Plot";
import "./digits.css";
import { asLogOdds, type Belief, type Readings, run, saturatedAt } from "./model";

const HEIGHT = 330;
const LEFT = 44;
const TOP = 48;
const BOTTOM = HEIGHT - 30;

const FORMS = [
  { form: "p", name: "probability p", label: "p" },
  { form: "odds", name: "odds", label: "odds" },
  { form: "logOdds", name: "log-odds ℓ", label: "ℓ" },
] as const;

const RAISED: Record<string, string> = {
  "-": "⁻",
  0: "⁰",
  1: "¹",
  2: "²",
  3: "³",
  4: "⁴",
  5: "⁵",
  6: "⁶",
  7: "⁷",
  8: "⁸",
  9: "⁹",
};

/** A 32-bit number as text: exactly 1, 0 and infinity are told from numbers near them. */
function plain(value: number): string {
  if (value === Infinity) return "∞";
  if (Number.isNaN(value)) return "not a number";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e6)) {
    const [digits, power] = value.toExponential(3).split("e");
    const raised = [...String(Number(power))].map((digit) => RAISED[digit] ?? digit).join("");
    return `${digits} · 10${raised}`.replace("-", "−");
  }
  return String(Number(value.toPrecision(9))).replace("-", "−");
}

/** The same hits and misses as probability, odds and log-odds in 32 bits, and where each form saturates. */
export function Digits({ readings }: { readings: Signal<Readings> }) {
  const path = useMemo(() => computed(() => run(readings.value)), [readings]);
  const cursor = useSignal<number | null>(null);
  const { hits, misses, pHit } = readings.value;
  const total = hits + misses;
  const at = Math.min(cursor.value ?? total, total);
  const now = path.value[at] ?? { p: 0.5, odds: 1, logOdds: 0 };
  return (
    <figure class="digits stack" aria-label="The same evidence stored as probability, as odds and as log-odds">
      <Plot height={HEIGHT} label={summary(path.value)}>
        {(width) => <Lines path={path.value} hits={hits} misses={misses} at={at} width={width} />}
      </Plot>
      <Slider
        label="Show the belief after reading"
        sentence="Selects the reading after which the table below shows the three values."
        value={at}
        initial={total}
        low={0}
        high={total}
        step={1}
        onInput={(value) => {
          cursor.value = value;
        }}
      />
      <div class="table-room">
        <table class="digits-values">
          <thead>
            <tr>
              <th scope="col">in 32 bits</th>
              <th scope="col">after reading {at}</th>
              <th scope="col">as log-odds</th>
            </tr>
          </thead>
          <tbody>
            {FORMS.map(({ form, name }) => {
              const value = form === "p" ? now.p : form === "odds" ? now.odds : now.logOdds;
              const l = asLogOdds(now, form);
              return (
                <tr key={form} class={Number.isFinite(l) ? "" : "lost"}>
                  <th scope="row" class={form}>
                    {name}
                  </th>
                  <td>{plain(value)}</td>
                  <td>{Number.isFinite(l) ? written(l, 2) : l > 0 ? "+∞" : "−∞"}</td>
                </tr>
              );
            })}
          </tbody>
        </table>
      </div>
      <figcaption>
        One hit adds {signed(logOdds(pHit))}, one miss {signed(-logOdds(pHit))}. {summary(path.value)}
      </figcaption>
    </figure>
  );
}

interface LinesProps {
  readonly path: readonly Belief[];
  readonly hits: number;
  readonly misses: number;
  readonly at: number;
  readonly width: number;
}

function Lines({ path, hits, misses, at, width }: LinesProps) {
  const right = width - 12;
  const total = hits + misses;
  const sums = path.map((belief) => belief.logOdds);
  const low = Math.min(-5, ...sums);
  const high = Math.max(20, ...sums) * 1.06;
  const x = (i: number): number => LEFT + ((right - LEFT) * i) / Math.max(1, total);
  const y = (l: number): number => BOTTOM - ((BOTTOM - TOP) * (l - low)) / (high - low);
  const lines = FORMS.map(({ form }) =>
    path
      .map((belief, i) => {
        const l = asLogOdds(belief, form);
        return `${i === 0 ? "M" : "L"}${x(i).toFixed(1)} ${(l === Infinity ? (form === "p" ? 9 : 15) : y(Math.max(low, l))).toFixed(1)}`;
      })
      .join(""),
  );
  const every = high > 150 ? 50 : high > 60 ? 20 : 10;
  const ticks = Array.from({ length: 24 }, (_, i) => (i - 12) * every).filter((tick) => tick >= low && tick < high);
  return (
    <>
      <rect class="digits-lost" x={LEFT} y={2} width={right - LEFT} height={38} rx={4} />
      <text class="tick" x={right - 8} y={34} text-anchor="end">
        {width < 480 ? "saturated" : "saturated: no further reading can change it"}
      </text>
      <rect class="zone-hit" x={LEFT} y={TOP} width={x(hits) - LEFT} height={BOTTOM - TOP} />
      <rect class="zone-miss" x={x(hits)} y={TOP} width={right - x(hits)} height={BOTTOM - TOP} />
      {ticks.map((tick) => (
        <g key={tick} class="tick">
          <line class={tick === 0 ? "zero" : "grid"} x1={LEFT} x2={right} y1={y(tick)} y2={y(tick)} />
          <text x={LEFT - 7} y={y(tick) + 4} text-anchor="end">
            {tick === 0 ? "0" : signed(tick, 0)}
          </text>
        </g>
      ))}
      {FORMS.map(({ form }, i) => (
        <path key={form} class={`digits-line ${form}`} d={lines[i] ?? ""} />
      ))}
      <line class="digits-cursor" x1={x(at)} x2={x(at)} y1={2} y2={BOTTOM} />
      <text class="tick" x={(LEFT + x(hits)) / 2} y={HEIGHT - 10} text-anchor="middle">
        {hits} hits
      </text>
      {misses > 0 && (
        <text class="tick" x={(x(hits) + right) / 2} y={HEIGHT - 10} text-anchor="middle">
          {misses} misses
        </text>
      )}
    </>
  );
}

function summary(path: readonly Belief[]): string {
  const [p, odds] = [saturatedAt(path, "p"), saturatedAt(path, "odds")];
  const end = path.at(-1)?.logOdds ?? 0;
  const first =
    p === null
      ? "The probability does not saturate."
      : `At reading ${p} the probability becomes exactly ${path[p]?.p}.`;
  const second =
    odds === null
      ? "The odds do not saturate."
      : `At reading ${odds} the odds ${path[odds]?.odds === 0 ? "underflow to 0" : "overflow"}.`;
  return `${first} ${second} The final log-odds are ${signed(end)}.`;
}
