import type { Brush } from "../../render/picture/brush";
import { toScreen } from "../../render/view";
import type { Store } from "../../store/store";
import { lazy } from "../../ui/lazy";
import type { Point } from "../../wire/protocol";
import type { PagePart } from "../part";
import "./poseGraph";

function dots(brush: Brush, points: readonly Point[], colour: string, side: number): void {
  const { ctx, view, size } = brush;
  ctx.fillStyle = colour;
  for (const [x, y] of points) {
    const [sx, sy] = toScreen(view, size, x, y);
    ctx.fillRect(sx - side / 2, sy - side / 2, side, side);
  }
}

/** Crosses, so that the two scans differ not only by colour. */
function crosses(brush: Brush, points: readonly Point[], colour: string): void {
  const { ctx, view, size } = brush;
  ctx.beginPath();
  for (const [x, y] of points) {
    const [sx, sy] = toScreen(view, size, x, y);
    ctx.moveTo(sx - 3, sy - 3);
    ctx.lineTo(sx + 3, sy + 3);
    ctx.moveTo(sx - 3, sy + 3);
    ctx.lineTo(sx + 3, sy - 3);
  }
  ctx.lineWidth = 1.5;
  ctx.strokeStyle = colour;
  ctx.stroke();
}

/** The two scans of a loop over the map: the first at its pose, the second at its pose and as placed by the loop. */
function paintScanPair(store: Store, brush: Brush): void {
  const pair = store.scanPair.peek();
  if (!pair) return;
  const { ctx, view, size, colours } = brush;
  dots(brush, pair.points.i, colours.miss, 4);
  ctx.globalAlpha = pair.points.aligned ? 0.45 : 1;
  crosses(brush, pair.points.j, colours.hit);
  ctx.globalAlpha = 1;
  if (pair.points.aligned) crosses(brush, pair.points.aligned, colours.beam);
  const [from, to] = pair.poses.map(([x, y]) => toScreen(view, size, x, y));
  if (!from || !to) return;
  ctx.beginPath();
  ctx.moveTo(...from);
  ctx.lineTo(...to);
  ctx.lineWidth = 3;
  ctx.strokeStyle = colours.outline;
  ctx.stroke();
  for (const [place, colour] of [
    [from, colours.miss],
    [to, colours.hit],
  ] as const) {
    ctx.beginPath();
    ctx.arc(...place, 5, 0, 2 * Math.PI);
    ctx.fillStyle = colour;
    ctx.fill();
    ctx.strokeStyle = colours.halo;
    ctx.stroke();
  }
}

const SlamGroup = lazy(async () => (await import("./SlamGroup")).SlamGroup);

export const PART: PagePart = {
  overlay: { watch: (store) => void store.scanPair.value, paint: paintScanPair },
  lab: [
    {
      id: "slam",
      title: "SLAM",
      section: "Errors",
      purpose: "Drifting wheels, and their path corrected while the robot drives",
      keeps: true,
      content: ({ store }) => <SlamGroup store={store} />,
    },
  ],
};
