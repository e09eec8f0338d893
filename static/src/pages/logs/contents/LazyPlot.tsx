import { lazy } from "../../../ui/lazy";

/** A plot over time. uPlot is loaded when the first one is shown. */
export const Plot = lazy(async () => (await import("./Plot")).Plot);
