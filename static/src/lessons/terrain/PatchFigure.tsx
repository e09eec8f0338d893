import { useSignal } from "@preact/signals";
import { consensus, type Limits, momentsOf, type Place, planeOf } from "./model";
import { Matrix, Result } from "./PatchNumbers";
import { PatchView } from "./PatchView";

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
