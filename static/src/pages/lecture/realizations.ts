import type { SketchName } from "../../lessons/matching/Sketch";

/** The ways in which poses are corrected by matching, each with its drawing and one sentence. */
export const REALIZATIONS: readonly {
  readonly name: string;
  readonly sketch: SketchName;
  readonly sentence: string;
}[] = [
  {
    name: "ICP",
    sketch: "icp",
    sentence:
      "Iterative closest point: pair each point with the nearest one, move the scan so that the pairs fit, and repeat.",
  },
  {
    name: "Scan to scan",
    sketch: "scan-to-scan",
    sentence: "Each scan is matched with the one before; small errors still add up.",
  },
  {
    name: "Scan to map",
    sketch: "scan-to-map",
    sentence: "Each scan is matched with the map so far, or its newest part; errors add up more slowly.",
  },
  {
    name: "Map to map",
    sketch: "map-to-map",
    sentence: "Two maps of a few scans each are matched; they show more than single scans.",
  },
  {
    name: "Feature-based",
    sketch: "features",
    sentence: "Corners and straight walls are found in both, and matched instead of points.",
  },
  {
    name: "RANSAC",
    sketch: "ransac",
    sentence: "Poses are computed from a few pairs drawn at random; the one that most pairs agree with is kept.",
  },
  {
    name: "Correlative",
    sketch: "correlative",
    sentence: "Every pose of a window is scored on a raster; a coarser raster bounds the score and rules most out.",
  },
];
