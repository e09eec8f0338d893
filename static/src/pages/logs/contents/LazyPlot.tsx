import { lazy } from "../../../ui/lazy";

/** A plot over time. uPlot is fetched when one is first shown. */
export const Plot = lazy(async () => (await import("./Plot")).Plot);
