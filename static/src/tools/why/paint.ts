/** The beams that updated the explained cell: all of them faint, the selected one in full. */

import { centreOf } from "../../grid/lattice";
import { type Brush, paintBeam, paintCell } from "../../render/picture/brush";
import { toScreen } from "../../render/view";
import type { Store } from "../../store/store";

export function paintWhy(store: Store, brush: Brush): void {
  const cell = store.explainedCell.peek();
  const map = store.explainedMap.peek();
  const frame = store.frame.peek();
  if (!cell || !map || !frame) return;
  const { ctx, view, size, colours } = brush;
  const why = store.why.peek();
  const selected = store.selectedContribution.peek();
  const [x, y] = toScreen(view, size, ...centreOf(map.geometry, cell));
  for (const kind of ["miss", "hit"] as const) {
    ctx.beginPath();
    for (const { hit, pose } of why?.contributions ?? []) {
      if (hit !== (kind === "hit")) continue;
      ctx.moveTo(...toScreen(view, size, pose[0], pose[1]));
      ctx.lineTo(x, y);
    }
    ctx.globalAlpha = kind === "hit" ? 0.22 : 0.14;
    ctx.lineWidth = 1;
    ctx.strokeStyle = colours[kind];
    ctx.stroke();
  }
  ctx.globalAlpha = 1;
  if (selected) {
    // In the colour of a hit or a miss, to distinguish it from the beams of the newest scan.
    const beam = colours[selected.hit ? "hit" : "miss"];
    const own = { ...brush, colours: { ...colours, beam } };
    paintBeam(own, selected.pose, { ...selected, index: selected.beam }, frame.range_max);
    const [sx, sy] = toScreen(view, size, selected.pose[0], selected.pose[1]);
    ctx.beginPath();
    ctx.arc(sx, sy, 5, 0, 2 * Math.PI);
    ctx.fillStyle = colours.halo;
    ctx.fill();
    ctx.lineWidth = 2;
    ctx.strokeStyle = beam;
    ctx.stroke();
  }
  paintCell(
    brush,
    map.geometry,
    cell.row,
    cell.col,
    selected ? colours[selected.hit ? "hit" : "miss"] : colours.outline,
  );
}
