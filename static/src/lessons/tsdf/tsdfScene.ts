/** A wall of the map in whole cells. */

import { type Scene, scene, WALL_CELL } from "../stage/scene";

export const tsdfScene = (): Scene =>
  scene({
    scans: 77,
    trinary: true,
    marks: ["lines"],
    view: { x: WALL_CELL[0], y: WALL_CELL[1], width: 2.4, height: 1.6 },
    caption:
      "A wall of the map in cells of 10 cm, which are occupied or not. Where in its cell the wall is, and which way it faces, is not in this map.",
  });
