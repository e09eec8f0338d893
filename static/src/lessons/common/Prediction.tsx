import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { classroom } from "../../store/classroom";
import { Button } from "../../ui/Button";
import { bound } from "../../ui/bound";
import { shownDecimals, written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { Variables } from "../../ui/text/Variables";
import { GuessColumns, type GuessQuestion, useClassGuess } from "./classGuess";
import { Plot } from "./Plot";
import { useSeen } from "./useSteps";
import "./lesson.css";

const HEIGHT = 92;
const AXIS = 66;
const PAD = 14;
const PARTS = 4;
/** In a narrower place every second number of the axis is left out, pixels. */
const ROOMY_PX = 340;

/** Resolves after the next frame is painted: what is shown before a long computation is on the screen during it. */
const framePainted = (): Promise<void> =>
  new Promise((done) => {
    requestAnimationFrame(() => setTimeout(done));
  });

interface PredictionProps extends GuessQuestion {
  /** Step of the guess. */
  readonly step: number;
  /** Brings the figure into the state that was asked about, and returns the number to be guessed. */
  readonly reveal: () => number | Promise<number>;
  /** Why the number is right, shown beside it. */
  readonly because?: string;
}

/** A question about the figure above: a number is guessed, then the figure shows it. In a class everybody guesses. */
export function Prediction({ text, axis, step, reveal, because }: PredictionProps) {
  const root = useRef<HTMLElement>(null);
  const middle = (axis.low + axis.high) / 2;
  const guess = useSignal(middle);
  const result = useSignal<number | null>(null);
  const isPending = useSignal(false);
  const hasFailed = useSignal(false);
  const showResult = async (): Promise<void> => {
    isPending.value = true;
    hasFailed.value = false;
    try {
      await framePainted();
      result.value = await reveal();
    } catch {
      hasFailed.value = true;
    } finally {
      isPending.value = false;
    }
  };
  const { asked, ask } = useClassGuess({ text, axis }, result.value, useSeen(root).value);
  const awaits = asked !== null && !asked.is_revealed && (classroom.value?.isFollowed ?? false);
  const places = shownDecimals(step);
  const unit = axis.unit ? ` ${axis.unit}` : "";
  const formatted = (value: number): string => `${written(value, places)}${unit}`;
  return (
    <section class="prediction no-print" ref={root} aria-label={`Predict: ${text}`}>
      <p class="prediction-question">
        <b>Predict.</b> <Variables text={text} />
      </p>
      <Plot height={HEIGHT}>
        {(width) => {
          const x = (value: number): number =>
            PAD + ((value - axis.low) / (axis.high - axis.low || 1)) * (width - 2 * PAD);
          return (
            <>
              {asked && <GuessColumns asked={asked} x={x} foot={AXIS} height={AXIS - 20} />}
              <path class="prediction-axis" d={`M${x(axis.low)} ${AXIS}H${x(axis.high)}`} />
              {Array.from({ length: PARTS + 1 }, (_, i) => axis.low + (i / PARTS) * (axis.high - axis.low)).map(
                (tick, i) => (
                  <g key={tick}>
                    <path class="prediction-axis" d={`M${x(tick)} ${AXIS}v6`} />
                    {(i % 2 === 0 || width >= ROOMY_PX) && (
                      <text x={x(tick)} y={AXIS + 22} text-anchor={i === 0 ? "start" : i === PARTS ? "end" : "middle"}>
                        {i === PARTS ? formatted(tick) : written(tick, places)}
                      </text>
                    )}
                  </g>
                ),
              )}
              <path class="prediction-guess" d={`M${x(guess.value)} 18V${AXIS}`} />
              {result.value !== null && (
                <path
                  class="prediction-right"
                  d={`M${x(Math.min(axis.high, result.value))} 10V${AXIS}m-6 -${AXIS - 10}h12`}
                />
              )}
            </>
          );
        }}
      </Plot>
      <div class="figure-controls">
        <Slider
          label="My guess"
          sentence="Your guess, the dashed line on the axis above."
          {...bound(guess)}
          initial={middle}
          low={axis.low}
          high={axis.high}
          step={step}
          unit={axis.unit ?? ""}
          disabled={result.value !== null}
        />
        {ask && result.value === null && (
          <Button icon="people" onClick={ask}>
            Ask the class
          </Button>
        )}
        {result.value === null ? (
          <Button kind="primary" disabled={awaits || isPending.value} onClick={() => void showResult()}>
            {isPending.value ? "Computing …" : "Show the result"}
          </Button>
        ) : (
          <Button
            icon="restart"
            onClick={() => {
              result.value = null;
            }}
          >
            Guess again
          </Button>
        )}
      </div>
      <p role="status">
        {result.value !== null && verdict(guess.value, result.value, step, formatted)}{" "}
        {result.value !== null && because && <Variables text={because} />}
        {hasFailed.value && "The result could not be loaded. Check the connection, and press the button again."}
        {awaits && "Answer at the bottom of the page; the lecturer shows the result."}
      </p>
    </section>
  );
}

function verdict(guess: number, was: number, step: number, formatted: (value: number) => string): string {
  const off = guess - was;
  if (Math.abs(off) < step) return `It is ${formatted(was)}. Your guess was right.`;
  return `It is ${formatted(was)}. Your guess was ${formatted(Math.abs(off))} too ${off > 0 ? "high" : "low"}.`;
}
