import { tokenRgb } from "../../style/colour";
import { bound } from "../../ui/bound";
import { Choice } from "../../ui/Choice";
import { bytes, written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { LOW_TABLE_HEIGHT } from "../stage/floor";
import { type Scene, scene } from "../stage/scene";
import { BYTES, CEILING, denseCells, POINTS, treeBytes } from "./model";
import "./octree.css";
import { computed } from "@preact/signals";
import { onPath } from "../stage/path";
import { cut, grown } from "./model";

/** What a reader can change, and the tree that it gives. */
const resolution = onPath(0.1);
const height = onPath(0.45);
const whole = computed(() => grown(resolution.value));
const tree = computed(() => cut(whole.value, height.value));

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

const RESOLUTIONS = [0.4, 0.2, 0.1, 0.05].map((metres) => ({
  value: String(metres),
  label: written(100 * metres, 0),
}));
const LASER = 0.45;

/** The memory of a dense grid, of an octree and of the points, at the chosen resolution. */
export function Octree() {
  const now = tree.value;
  const cells = denseCells(resolution.value);
  const dense = cells * BYTES.cell;
  const rows = [
    { name: "dense grid", count: `${cells.toLocaleString("en")} cells`, size: dense },
    {
      name: "octree",
      count: `${now.leaves.toLocaleString("en")} leaves, ${now.inner.toLocaleString("en")} inner nodes`,
      size: treeBytes(now),
    },
    { name: "points, kept raw", count: `${POINTS.toLocaleString("en")} points`, size: POINTS * BYTES.point },
  ];
  const most = Math.max(...rows.map(({ size }) => size));
  return (
    <div class="stack-narrow">
      <div class="figure-controls no-print">
        <Choice
          label="Finest cells (cm)"
          options={RESOLUTIONS}
          value={String(resolution.value)}
          sentence="Side of the finest cells of the octree, and of all cells of the dense grid."
          onChange={(value) => {
            resolution.value = Number(value);
          }}
        />
        <Slider
          label="Cut height"
          sentence="Height above the floor at which the stage shows the leaves."
          {...bound(height)}
          initial={LASER}
          low={0.05}
          high={CEILING - 0.1}
          step={0.05}
          unit="m"
        />
      </div>
      <div class="table-room">
        <table class="plain-table">
          <thead>
            <tr>
              <th scope="col">map</th>
              <th scope="col">holds</th>
              <th scope="col">memory</th>
            </tr>
          </thead>
          <tbody>
            {rows.map(({ name, count, size }) => (
              <tr key={name}>
                <th scope="row">{name}</th>
                <td>{count}</td>
                <td class="octree-size">
                  {bytes(size)}
                  <span class="octree-bar" style={{ width: `${(100 * size) / most}%` }} />
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      <p>
        Bytes: {BYTES.cell} per cell, {BYTES.leaf} per leaf, {BYTES.inner} per inner node, {BYTES.point} per point.
      </p>
    </div>
  );
}
