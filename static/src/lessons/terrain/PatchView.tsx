import { written } from "../../ui/numbers";
import { Plot } from "../common/Plot";
import { ValueHandle } from "../common/ValueHandle";
import { heightAt, type Place, type Plane } from "./model";

const HEIGHT = 280;
const HEIGHTS = { low: -0.3, high: 0.9, step: 0.01 };
/** Radius of a point, px. */
const DOT = 7;

interface PatchViewProps {
  readonly points: readonly Place[];
  readonly plane: Plane | null;
  /** Which points the plane is fitted to. */
  readonly used: readonly boolean[];
  readonly onMove: (index: number, z: number) => void;
}

/** The points of a patch in an oblique view, their plane, and how far each is from it; points are dragged up and down. */
export function PatchView({ points, plane, used, onMove }: PatchViewProps) {
  return (
    <Plot height={HEIGHT}>
      {(width) => {
        const metre = Math.min(width / 3.2, 150);
        const at = (x: number, y: number, z: number): readonly [number, number] => [
          width / 2 + metre * (0.95 * x + 0.42 * y),
          HEIGHT - 66 - metre * (0.34 * y + z),
        ];
        const corners = (height: (x: number, y: number) => number): string =>
          [
            [-1, -1],
            [1, -1],
            [1, 1],
            [-1, 1],
          ]
            .map(([x = 0, y = 0]) => at(x, y, height(x, y)).join(" "))
            .join("L");
        return (
          <>
            <path class="patch-ground" d={`M${corners(() => 0)}Z`} />
            {plane && <path class="patch-plane" d={`M${corners((x, y) => heightAt(plane, x, y))}Z`} />}
            {points.map(([x, y, z], k) => {
              const [px, py] = at(x, y, z);
              const onPlane = plane ? at(x, y, heightAt(plane, x, y))[1] : py;
              return (
                <g key={k}>
                  <path class="patch-stem" d={`M${at(x, y, 0).join(" ")}V${py}`} />
                  <path class="patch-residual" d={`M${px} ${onPlane}V${py}`} />
                </g>
              );
            })}
            {points.map(([x, y, z], k) => {
              const [px, py] = at(x, y, z);
              return (
                <PointHandle
                  key={k}
                  index={k}
                  z={z}
                  at={[px, py]}
                  metre={metre}
                  isUsed={used[k] ?? true}
                  onMove={(to) => onMove(k, to)}
                />
              );
            })}
          </>
        );
      }}
    </Plot>
  );
}

interface PointHandleProps {
  readonly index: number;
  readonly z: number;
  readonly at: readonly [number, number];
  readonly metre: number;
  readonly isUsed: boolean;
  readonly onMove: (z: number) => void;
}

function PointHandle({ index, z, at: [px, py], metre, isUsed, onMove }: PointHandleProps) {
  return (
    <ValueHandle
      label={`Point ${index + 1}`}
      sentence="Moves this point up or down."
      axis="y"
      tone={isUsed ? "tone-robot" : "tone-hit"}
      value={z}
      range={HEIGHTS}
      text={`${written(z, 2)} m high`}
      grab={{ x: px - 20, y: py - 20, width: 40, height: 40 }}
      perPixel={-1 / metre}
      onValue={onMove}
    >
      {isUsed ? (
        <circle class="patch-point" cx={px} cy={py} r={DOT} />
      ) : (
        <path class="patch-point left-out" d={`M${px - 6} ${py - 6}l12 12M${px + 6} ${py - 6}l-12 12`} />
      )}
    </ValueHandle>
  );
}
