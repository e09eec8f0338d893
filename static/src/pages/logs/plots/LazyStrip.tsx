import { lazy } from "../../../ui/lazy";

/** One low plot over time. uPlot is fetched when the first one is shown. */
export const Strip = lazy(async () => (await import("./Strip")).Strip);
