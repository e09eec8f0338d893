import type { ClassQuestion } from "../../wire/protocol";
import { barsOf, letterOf, spoken } from "./histogram";

/**
 * The answers to a question: a bar for each option, or columns on the axis of the guess. Before they are known, only
 * the options or the axis.
 */
export function Histogram({ question, own }: { readonly question: ClassQuestion; readonly own: number | null }) {
  const bars = barsOf(question);
  if (question.axis) return <Columns question={question} own={own} />;
  if (!question.counts)
    return (
      <ul class="class-bars is-withheld" aria-label={spoken(question)}>
        {question.options?.map((option, i) => (
          <li key={option}>
            <span>
              <b>{letterOf(i)}</b> {option}
            </span>
          </li>
        ))}
      </ul>
    );
  return (
    <ul class="class-bars" aria-label={spoken(question)}>
      {bars.map((bar, i) => (
        <li key={bar.label} class={bar.isRight ? "is-right" : ""}>
          <span class="class-bar-name">
            <b>{letterOf(i)}</b> {bar.label}
            {bar.isRight && <em> ✓ right</em>}
            {own === i && <em> · yours</em>}
          </span>
          <span class="class-bar" aria-hidden="true">
            <i style={`width: ${100 * bar.length}%`} />
          </span>
          <span class="number">{bar.count}</span>
        </li>
      ))}
    </ul>
  );
}

const WIDTH = 400;
const HEIGHT = 130;
const BASE = 104;

function Columns({ question, own }: { readonly question: ClassQuestion; readonly own: number | null }) {
  const { axis, right } = question;
  const bars = barsOf(question);
  if (!axis) return null;
  const x = (value: number): number => 10 + ((value - axis.low) / (axis.high - axis.low)) * (WIDTH - 20);
  const column = (WIDTH - 20) / Math.max(1, bars.length);
  return (
    <svg class="class-columns" viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label={spoken(question)}>
      {bars.map(({ label, length, count, isRight }, i) => (
        <rect
          key={label}
          class={isRight ? "is-right" : ""}
          x={10 + i * column + 1}
          width={column - 2}
          y={BASE - 80 * length}
          height={80 * length}
        >
          <title>{`${label}: ${count}`}</title>
        </rect>
      ))}
      <path class="class-axis" d={`M10 ${BASE}H${WIDTH - 10}`} />
      <text x={10} y={HEIGHT - 8}>
        {axis.low}
      </text>
      <text x={WIDTH - 10} y={HEIGHT - 8} text-anchor="end">
        {axis.high} {axis.unit}
      </text>
      {own !== null && <path class="class-own" d={`M${x(own)} ${BASE + 2}l-5 9h10z`} />}
      {right !== null && <path class="class-right" d={`M${x(right)} 14V${BASE}`} />}
    </svg>
  );
}
