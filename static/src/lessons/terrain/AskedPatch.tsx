/** The patch of terrain that was clicked: its points to grab, P, its plane, why it has its class, and its children. */

import { useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import { Button } from "../../ui/Button";
import { inHand } from "../../ui/browser/media";
import { written } from "../../ui/numbers";
import type { TerrainMessage } from "../../wire/messages";
import type { Values } from "../../wire/protocol";
import type { Limits, Place } from "./model";
import { PatchFigure } from "./PatchFigure";
import { Children } from "./PatchNumbers";
import "./terrain.css";

/** x, y, z of one point after the other as points. */
export function placesOf(flat: readonly number[]): readonly Place[] {
  const places: Place[] = [];
  for (let k = 0; k + 2 < flat.length; k += 3)
    places.push([flat[k] as number, flat[k + 1] as number, flat[k + 2] as number]);
  return places;
}

/** The heights that are shown: those of the points, with room to drag them, m. */
export function heightsOf(points: readonly Place[], half: number): readonly [number, number] {
  const all = points.map(([, , z]) => z);
  const low = Math.min(...all);
  const high = Math.max(...all);
  const room = Math.max(0.25 * (high - low), 0.3 * half);
  return [low - 0.3 * room, high + room];
}

/** The limits, weights and rule among the parameters of a terrain. */
export function limitsOf(values: Values): Limits {
  const number = (name: string): number => Number(values[name]);
  return {
    slope: (number("max_slope") * Math.PI) / 180,
    roughness: number("max_roughness"),
    step: number("max_step"),
    weights: [number("slope_weight"), number("roughness_weight"), number("step_weight")],
    isThresholds: values.rule === "thresholds",
  };
}

export function AskedPatch({ message }: { readonly message: TerrainMessage }) {
  const { patch, values } = message;
  if (!patch) {
    return (
      <p class="quiet">
        Click a patch on the map: its points, the plane through them and why it is safe or not are shown here.
      </p>
    );
  }
  return (
    <Asked
      key={`${patch.centre} ${patch.half} ${patch.n} ${patch.points.slice(0, 6)}`}
      patch={patch}
      size={message.size}
      values={values}
      fit={String(values.fit)}
    />
  );
}

interface AskedProps {
  readonly patch: NonNullable<TerrainMessage["patch"]>;
  readonly size: number;
  readonly values: Values;
  readonly fit: string;
}

function Asked({ patch, size, values, fit }: AskedProps) {
  const points: readonly Place[] = useMemo(() => placesOf(patch.points), [patch.points.join()]);
  const edges: readonly Place[] = useMemo(() => placesOf(patch.edges), [patch.edges.join()]);
  const limits: Limits = limitsOf(values);
  const heights = heightsOf(points, patch.half);
  const attempt = useSignal(0);
  const isMoved = useSignal(false);
  const across = Math.round((2 * patch.half) / size);
  const x = written(patch.x, 1);
  const y = written(patch.y, 1);
  return (
    <section class="terrain-asked patch stack" aria-label="The patch that was clicked">
      <p>
        <b>
          {across > 1 ? `Window of ${across} × ${across} patches of` : "Patch of"} {written(size, 2)} m at ({x}, {y})
        </b>
        , in the map {patch.why.replace(/^Terrain: /, "")} {inHand("Click the map for another.")}
      </p>
      {points.length === 0 ? (
        <p class="quiet">It has no ground points.</p>
      ) : (
        <>
          <PatchFigure
            key={attempt.value}
            initial={points}
            half={patch.half}
            heights={heights}
            floor={heights[0]}
            robust={fit === "ransac" ? Number(values.fit_distance) : null}
            limits={limits}
            edges={edges}
            onMoved={() => {
              isMoved.value = true;
            }}
          />
          <p class="quiet">
            {pointsSentence(points.length, patch.n)} Drag one up or down: the entries of P that change are marked, and
            the plane and the class follow. The map keeps its points. Heights are above {written(patch.base, 0)} m.
          </p>
          {isMoved.value && (
            <Button
              kind="quiet"
              onClick={() => {
                isMoved.value = false;
                attempt.value++;
              }}
            >
              Put the points back
            </Button>
          )}
        </>
      )}
      {patch.children.length > 0 && (
        <>
          <p class="quiet">
            This patch is the parent of four in the quadtree. Its P is the sum of theirs, moved to its centre:
          </p>
          <Children moments={patch.children} />
        </>
      )}
    </section>
  );
}

const pointsSentence = (shown: number, n: number): string =>
  shown < n
    ? `${shown} of its ${n.toLocaleString("en")} ground points; P, plane and class below are of these.`
    : `Its ${shown} ground points.`;
