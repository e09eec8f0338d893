import { effect, type ReadonlySignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";
import { shownByteAt } from "../../grid/cellValues";
import { fromLattice, toLattice } from "../../grid/lattice";
import type { GridGeometry, OccupancyGrid } from "../../grid/occupancyGrid";
import { mapColours, palette } from "../../render/map/palettes";
import { isDark } from "../../ui/browser/theme";
import type { Point } from "../../wire/protocol";
import "./lesson.css";
import { useDrawing } from "../../ui/browser/useDrawing";

/** Where the world lies on a stage: metres to pixels and back. y points up in the world, down on the screen. */
export interface StageTransform {
  readonly width: number;
  readonly height: number;
  /** Pixels of a metre, and of a cell. */
  readonly metre: number;
  readonly cell: number;
  x(metres: number): number;
  y(metres: number): number;
  world(px: number, py: number): Point;
}

const transformOf = (geometry: GridGeometry, width: number): StageTransform => {
  const cell = width / geometry.cols;
  const height = cell * geometry.rows;
  return {
    width,
    height,
    cell,
    metre: cell / geometry.resolution,
    x: (metres) => toLattice(geometry, metres, 0)[0] * cell,
    y: (metres) => height - toLattice(geometry, 0, metres)[1] * cell,
    world: (px, py) => fromLattice(geometry, px / cell, (height - py) / cell),
  };
};

/** Log-odds at the ends of the colour scale. */
const RANGE = { low: -2.5, high: 3.5 };

function paint(canvas: HTMLCanvasElement, grid: OccupancyGrid): void {
  const { rows, cols } = grid.geometry;
  const context = canvas.getContext("2d");
  if (!context) return;
  const colours = palette(RANGE, mapColours());
  const image = context.createImageData(cols, rows);
  for (let row = 0; row < rows; row++)
    for (let col = 0; col < cols; col++) {
      const index = row * cols + col;
      const byte = Math.round(shownByteAt(grid.logOdds[index] ?? 0, RANGE));
      const from = 4 * (grid.observed[index] === 1 ? byte : 0);
      image.data.set(colours.subarray(from, from + 4), 4 * ((rows - 1 - row) * cols + col));
    }
  context.putImageData(image, 0, 0);
}

function paintGreys(canvas: HTMLCanvasElement, greys: Uint8Array): void {
  const context = canvas.getContext("2d");
  if (!context) return;
  const image = context.createImageData(canvas.width, canvas.height);
  greys.forEach((grey, i) => {
    image.data.set([grey, grey, grey, 255], 4 * i);
  });
  context.putImageData(image, 0, 0);
}

function paintColours(canvas: HTMLCanvasElement, colours: Uint8ClampedArray<ArrayBuffer>): void {
  canvas.getContext("2d")?.putImageData(new ImageData(colours, canvas.width, canvas.height), 0, 0);
}

interface StageProps {
  readonly geometry: GridGeometry;
  /** Description for screen readers. */
  readonly label: string;
  /** The map to paint; without it the background is plain. */
  readonly grid?: ReadonlySignal<OccupancyGrid>;
  /** An image instead of a map: greys, top row first. */
  readonly greys?: ReadonlySignal<Uint8Array>;
  /** An image instead of a map: RGBA, top row first. */
  readonly colours?: ReadonlySignal<Uint8ClampedArray<ArrayBuffer>>;
  /** Draw the borders of the cells. */
  readonly lines?: boolean;
  readonly children?: (transform: StageTransform) => ComponentChildren;
}

/**
 * A part of the world: its cells as a canvas, and over them an SVG drawing in pixels. Its height is kept while it
 * loads.
 */
export function Stage({ geometry, label, grid, greys, colours, lines, children }: StageProps) {
  const box = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const size = useDrawing(box, 480);
  // Before it is shown, and before it is printed.
  useLayoutEffect(
    () =>
      effect(() => {
        void isDark.value;
        if (canvas.current && grid) paint(canvas.current, grid.value);
        if (canvas.current && greys) paintGreys(canvas.current, greys.value);
        if (canvas.current && colours) paintColours(canvas.current, colours.value);
      }),
    [grid, greys, colours],
  );
  const { width, scale } = size.value;
  const now = transformOf(geometry, width);
  return (
    <div class="stage" ref={box} style={{ "aspect-ratio": `${geometry.cols} / ${geometry.rows}` }}>
      {(grid || greys || colours) && (
        <canvas ref={canvas} width={geometry.cols} height={geometry.rows} role="img" aria-label={label} />
      )}
      {!(grid || greys || colours) && <p class="visually-hidden">{label}</p>}
      <svg
        class="drawing"
        style={{ zoom: scale }}
        width={now.width}
        height={now.height}
        viewBox={`0 0 ${now.width} ${now.height}`}
        role="presentation"
      >
        {lines && <Lines geometry={geometry} transform={now} />}
        {children?.(now)}
      </svg>
    </div>
  );
}

function Lines({ geometry, transform }: { geometry: GridGeometry; transform: StageTransform }) {
  const path = [
    ...Array.from({ length: geometry.cols - 1 }, (_, i) => `M${(i + 1) * transform.cell} 0V${transform.height}`),
    ...Array.from({ length: geometry.rows - 1 }, (_, i) => `M0 ${(i + 1) * transform.cell}H${transform.width}`),
  ];
  return <path class="cell-lines" d={path.join("")} />;
}
