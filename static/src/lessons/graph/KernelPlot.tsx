import { Plot } from "../common/Plot";
import { type Kernel, robustWeight } from "./solver";

const HEIGHT = 152;
const PAD = { left: 34, right: 14, top: 32, bottom: 42 };
/** Standard deviations at the right end. */
const FARTHEST = 30;
const TICKS = [0, 5, 10, 15, 20, 25, 30];

interface KernelPlotProps {
  readonly kernel: Kernel;
  readonly scale: number;
  readonly loops: readonly { readonly name: string; readonly residual: number; readonly weight: number }[];
}

/** The weight that the kernel leaves of a loop, over its residual, with the loops of the graph on the curve. */
export function KernelPlot({ kernel, scale, loops }: KernelPlotProps) {
  return (
    <Plot height={HEIGHT} label="Weight of a loop over its residual in standard deviations">
      {(width) => {
        const x = (residual: number): number =>
          PAD.left + (Math.min(residual, FARTHEST) / FARTHEST) * (width - PAD.left - PAD.right);
        const y = (weight: number): number => PAD.top + (1 - weight) * (HEIGHT - PAD.top - PAD.bottom);
        const curve = Array.from({ length: 121 }, (_, k) => {
          const residual = (FARTHEST * k) / 120;
          return `${k ? "L" : "M"}${x(residual).toFixed(1)} ${y(robustWeight(kernel, residual * residual, scale)).toFixed(1)}`;
        });
        return (
          <>
            <path class="kernel-axes" d={`M${PAD.left} ${PAD.top}V${y(0)}H${width - PAD.right}`} />
            {[0, 1].map((weight) => (
              <text key={weight} class="kernel-tick" x={PAD.left - 6} y={y(weight) + 4} text-anchor="end">
                {weight}
              </text>
            ))}
            {TICKS.map((tick) => (
              <text key={tick} class="kernel-tick" x={x(tick)} y={y(0) + 18} text-anchor="middle">
                {tick}
              </text>
            ))}
            <text class="kernel-tick" x={width - PAD.right} y={HEIGHT - 5} text-anchor="end">
              residual, standard deviations
            </text>
            <text class="kernel-tick" x={0} y={14}>
              weight of a loop
            </text>
            <path class="kernel-curve" d={curve.join("")} />
            {loops.map(({ name, residual, weight }) => (
              <g key={name} transform={`translate(${x(residual)} ${y(weight)})`}>
                <circle class="kernel-loop" r={5} />
                <text
                  x={residual > 0.7 * FARTHEST ? -9 : 9}
                  y={-4}
                  text-anchor={residual > 0.7 * FARTHEST ? "end" : "start"}
                >
                  {name}
                </text>
              </g>
            ))}
          </>
        );
      }}
    </Plot>
  );
}
