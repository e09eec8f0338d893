import { useSignal } from "@preact/signals";
import { type Range, written } from "../../ui/numbers";
import { Plot } from "../common/Plot";
import { ValueHandle } from "../common/ValueHandle";
import { consensus, heightAt, type Limits, momentsOf, type Place, type Plane, planeOf } from "./model";
import { Matrix, Result } from "./PatchNumbers";

const HEIGHT = 260;
/** Points that can be grabbed at most; of more every second one, or fewer. */
const MOST_GRABBED = 40;
/** Radius of a point that is grabbed, and of one that is not, px. */
const DOT = 7;
const SMALL_DOT = 2.5;

interface PatchViewProps {
  readonly points: readonly Place[];
  /** Half of the patch's side, m. */
  readonly half: number;
  /** The heights that are shown, m. */
  readonly heights: readonly [low: number, high: number];
  /** The height of the level square under the points, m. */
  readonly floor: number;
  readonly plane: Plane | null;
  /** Which points the plane is fitted to. */
  readonly used: readonly boolean[];
  readonly onMove: (index: number, z: number) => void;
}

/** The points of a patch in an oblique view, their plane, and how far each is from it; points are dragged up and down. */
function PatchView({ points, half, heights, floor, plane, used, onMove }: PatchViewProps) {
  const [low, high] = heights;
  const range = { low, high, step: high - low > 0.5 ? 0.01 : 0.001 };
  const every = Math.max(1, Math.ceil(points.length / MOST_GRABBED));
  return (
    <Plot height={HEIGHT}>
      {(width) => {
        const metre = Math.min(width / 3.2, 150) / half;
        // Above and below the heights there is room for the far and the near edge of the square.
        const up = Math.min(metre, (HEIGHT - 30 - 0.68 * metre * half) / (high - low));
        const bottom = HEIGHT - 15 - 0.34 * metre * half;
        const at = (x: number, y: number, z: number): readonly [number, number] => [
          width / 2 + metre * (0.95 * x + 0.42 * y),
          bottom - metre * 0.34 * y - up * (z - low),
        ];
        const corners = (height: (x: number, y: number) => number): string =>
          [
            [-half, -half],
            [half, -half],
            [half, half],
            [-half, half],
          ]
            .map(([x = 0, y = 0]) => at(x, y, height(x, y)).join(" "))
            .join("L");
        return (
          <>
            <path class="patch-ground" d={`M${corners(() => floor)}Z`} />
            {plane && <path class="patch-plane" d={`M${corners((x, y) => heightAt(plane, x, y))}Z`} />}
            {points.map(([x, y, z], k) => {
              const [px, py] = at(x, y, z);
              const onPlane = plane ? at(x, y, heightAt(plane, x, y))[1] : py;
              return (
                <g key={k}>
                  {every === 1 && <path class="patch-stem" d={`M${at(x, y, floor).join(" ")}V${py}`} />}
                  <path class={every === 1 ? "patch-residual" : "patch-residual thin"} d={`M${px} ${onPlane}V${py}`} />
                  {k % every > 0 && (
                    <circle class={`patch-dot ${used[k] ? "" : "left-out"}`} cx={px} cy={py} r={SMALL_DOT} />
                  )}
                </g>
              );
            })}
            {points.map(([x, y, z], k) => {
              if (k % every > 0) return null;
              const [px, py] = at(x, y, z);
              return (
                <PointHandle
                  key={k}
                  index={k}
                  z={z}
                  range={range}
                  at={[px, py]}
                  metre={up}
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
  readonly range: Range;
  readonly at: readonly [number, number];
  /** Pixels of a metre of height. */
  readonly metre: number;
  readonly isUsed: boolean;
  readonly onMove: (z: number) => void;
}

function PointHandle({ index, z, range, at: [px, py], metre, isUsed, onMove }: PointHandleProps) {
  return (
    <ValueHandle
      label={`Point ${index + 1}`}
      sentence="Moves this point up or down."
      axis="y"
      tone={isUsed ? "tone-robot" : "tone-hit"}
      value={z}
      range={range}
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

interface PatchFigureProps {
  /** The points to begin with. Another set of points takes another `key`. */
  readonly initial: readonly Place[];
  /** Half of the patch's side, m. */
  readonly half: number;
  /** The heights that are shown, m. */
  readonly heights: readonly [low: number, high: number];
  /** The height of the level square under the points, m. */
  readonly floor: number;
  /** The distance of RANSAC, m; null for least squares of all points. */
  readonly robust: number | null;
  /** Whether every point counts twice. */
  readonly isTwice?: boolean;
  readonly limits: Limits;
  /** Places in the middle of its edges, on the planes of its neighbours. */
  readonly edges?: readonly Place[];
  readonly onMoved?: () => void;
}

/** A patch that one grabs: its points are dragged up and down, and P, the plane and the class follow. */
export function PatchFigure(props: PatchFigureProps) {
  const { initial, half, heights, floor, robust, isTwice = false, limits, edges = [], onMoved } = props;
  const points = useSignal(initial);
  /** The points before the one that was moved last was moved. */
  const before = useSignal(initial);
  const moved = useSignal(-1);

  const used = robust === null ? points.value.map(() => true) : consensus(points.value, robust);
  const taken = (all: readonly Place[]): readonly Place[] => {
    const some = all.filter((_, k) => used[k]);
    return isTwice ? [...some, ...some] : some;
  };
  const moments = momentsOf(taken(points.value));
  const plane = planeOf(moments);
  return (
    <>
      <PatchView
        points={points.value}
        half={half}
        heights={heights}
        floor={floor}
        plane={plane}
        used={used}
        onMove={(index, z) => {
          if (moved.peek() !== index) before.value = points.peek();
          moved.value = index;
          points.value = points.peek().map(([x, y, old], k) => [x, y, k === index ? z : old]);
          onMoved?.();
        }}
      />
      <div class="patch-numbers">
        <Matrix moments={moments} before={momentsOf(taken(before.value))} />
        <Result plane={plane} limits={limits} edges={edges} />
      </div>
    </>
  );
}
