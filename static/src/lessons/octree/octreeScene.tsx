/** The leaves of the octree at a height, over the floor. */

import { tokenRgb } from "../../style/colour";
import { written } from "../../ui/numbers";
import { LOW_TABLE_HEIGHT } from "../stage/floor";
import { type Scene, scene } from "../stage/scene";
import { height, tree } from "./state";

const LINTEL = 2;

function caption(): string {
  const free = tree.value.slice.filter(({ state }) => state === "free");
  const largest = Math.max(...free.map(({ side }) => side));
  const seen =
    height.value < LOW_TABLE_HEIGHT
      ? "The low table is cut."
      : height.value >= LINTEL
        ? "The lintels close both doors."
        : "The low table is not in this plane: a map on a plane would call its place free.";
  return `At ${written(height.value, 2)} m above the floor the plane cuts ${tree.value.slice.length.toLocaleString("en")} leaves; the largest free one has a side of ${written(largest, 2)} m. ${seen}`;
}

export const octreeScene = (): Scene =>
  scene({
    scans: 77,
    bare: true,
    drawing: () => null,
    overlay: (context, at) => {
      const [free, occupied, line] = (["--miss-wash", "--hit-fill", "--line-strong"] as const).map(
        (token) => `rgb(${tokenRgb(token).join(" ")})`,
      );
      context.lineWidth = 0.75;
      for (const { x, y, side, state } of tree.value.slice) {
        const px = side * at.metre;
        context.fillStyle = (state === "free" ? free : occupied) ?? "";
        context.strokeStyle = line ?? "";
        context.fillRect(at.x(x), at.y(y + side), px, px);
        if (px > 3) context.strokeRect(at.x(x), at.y(y + side), px, px);
      }
    },
    caption,
  });
