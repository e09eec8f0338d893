import { useRef } from "preact/hooks";
import { Handle } from "../../ui/Handle";
import { written } from "../../ui/numbers";

const SIZE = 232;
const MIDDLE = SIZE / 2;
const [INNER, OUTER, TIP] = [46, 86, 104];
/** Pointers beyond this number are drawn as one ring. */
const MOST = 120;

const at = (turn: number, radius: number): string => {
  const angle = 2 * Math.PI * (turn - 0.25);
  return `${(MIDDLE + radius * Math.cos(angle)).toFixed(1)} ${(MIDDLE + radius * Math.sin(angle)).toFixed(1)}`;
};

function sector(from: number, to: number): string {
  const wide = to - from > 0.5 ? 1 : 0;
  if (to - from > 0.999) return `${sector(0, 0.5)}${sector(0.5, 1)}`;
  return `M${at(from, INNER)}L${at(from, OUTER)}A${OUTER} ${OUTER} 0 ${wide} 1 ${at(to, OUTER)}L${at(to, INNER)}A${INNER} ${INNER} 0 ${wide} 0 ${at(from, INNER)}Z`;
}

interface WheelProps {
  readonly weights: Float64Array;
  /** How often each particle is drawn. */
  readonly counts: Int32Array;
  /** Where the first pointer is between two, 0 … 1; null where the draws are independent. */
  readonly share: number | null;
  readonly onShare: (share: number) => void;
}

/** The weights as sectors of a wheel, and pointers at equal distances: table 4.4. One drags the first of them. */
export function Wheel({ weights, counts, share, onShare }: WheelProps) {
  const count = weights.length;
  const before = useRef(0);
  const sums = [0];
  for (const w of weights) sums.push((sums.at(-1) ?? 0) + w);
  const ring = [...weights.keys()].filter((i) => (weights[i] ?? 0) > 1e-4);
  const pointers = share === null ? [] : Array.from({ length: count }, (_, m) => (m + share) / count);
  const first = pointers[0] ?? 0;
  const [x, y] = at(first, TIP).split(" ").map(Number) as [number, number];
  const set = (value: number): void => onShare(Math.min(0.99, Math.max(0.01, value)));
  return (
    <svg class="wheel drawing" width={SIZE} height={SIZE} viewBox={`0 0 ${SIZE} ${SIZE}`} role="presentation">
      {ring.map((i) => (
        <path
          key={i}
          class={`wheel-sector${counts[i] ? " drawn" : ""}`}
          d={sector(sums[i] ?? 0, Math.min(1, sums[i + 1] ?? 1))}
        />
      ))}
      <path
        class="wheel-pointers"
        d={pointers
          .slice(0, MOST)
          .map((turn) => `M${at(turn, OUTER - 10)}L${at(turn, OUTER + 8)}`)
          .join("")}
      />
      <text x={MIDDLE} y={MIDDLE - 2} text-anchor="middle">
        {count}
      </text>
      <text class="wheel-unit" x={MIDDLE} y={MIDDLE + 16} text-anchor="middle">
        draws
      </text>
      {share !== null && (
        <Handle
          label="First pointer"
          sentence="Turns all pointers of the wheel at once: the one random number of the low-variance sampler."
          axis="x"
          tone="tone-robot"
          now={share}
          low={0}
          high={1}
          text={`${written(share, 2)} of the distance between two pointers`}
          grab={{ x: x - 20, y: y - 20, width: 40, height: 40 }}
          onStart={() => {
            before.current = share;
          }}
          onDrag={(dx, _, fine) => set(before.current + (dx * (fine ? 0.2 : 1) * count) / (2 * Math.PI * TIP))}
          onKey={(key, shift) => {
            const step = shift ? 0.01 : 0.05;
            const direction = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[key];
            if (direction) set(share + direction * step);
            return direction !== undefined;
          }}
        >
          <path class="wheel-first" d={`M${at(first, OUTER - 10)}L${at(first, TIP)}`} />
          <circle class="handle-mark" cx={x} cy={y} r={8} />
        </Handle>
      )}
    </svg>
  );
}
