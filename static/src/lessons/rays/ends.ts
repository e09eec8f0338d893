/** The ends of the line in the figure of rays, in cells. */

import type { Point } from "../../wire/protocol";
import { onPath } from "../stage/path";

export const rayFrom = onPath<Point>([4.4, 3.5]);
export const rayTo = onPath<Point>([22.6, 10.7]);
