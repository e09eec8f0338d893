import { effect, type Signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { brushOn } from "../../../render/picture/brush";
import { type LayerContent, paintLayer } from "../../../render/picture/overlays";
import { pictureColours } from "../../../render/picture/pictureColours";
import type { Store } from "../../../store/store";
import { written } from "../../../ui/numbers";
import type { TrajectoryErrors } from "../../../wire/http";

interface ErrorPathsProps {
  readonly store: Store;
  readonly errors: Signal<TrajectoryErrors | null>;
}

/** Both paths of a comparison over the map; the compared one is coloured by its absolute error. */
export function ErrorPaths({ store, errors }: ErrorPathsProps) {
  return errors.value && <Paths store={store} errors={errors.value} />;
}

function Paths({ store, errors }: { readonly store: Store; readonly errors: TrajectoryErrors }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const element = canvas.current;
    if (!element) return;
    const layers = [lineOf(errors.paths.reference), colouredLineOf(errors.paths)];
    const paint = (): void => {
      const view = store.view.value;
      const colours = pictureColours.value;
      const { clientWidth: width, clientHeight: height } = element;
      element.width = Math.round(width * devicePixelRatio);
      element.height = Math.round(height * devicePixelRatio);
      const brush = view && brushOn(element, { width, height }, devicePixelRatio, view, colours);
      if (brush) for (const layer of layers) paintLayer(brush, layer);
    };
    const stop = effect(paint);
    const observer = new ResizeObserver(paint);
    observer.observe(element);
    return () => {
      stop();
      observer.disconnect();
    };
  }, [store, errors]);
  const shades = pictureColours.value.shades;
  const { min, max } = errors.absolute.translation_m;
  return (
    <>
      <canvas class="error-paths" ref={canvas} />
      <p class="error-legend">
        {written(min, 2)} m
        <span style={{ background: `linear-gradient(to right, ${shades.join(", ")})` }} />
        {written(max, 2)} m
      </p>
    </>
  );
}

type Places = TrajectoryErrors["paths"]["reference"];

const columnsOf = (places: Places): Float32Array[] => [0, 1].map((i) => Float32Array.from(places, (at) => at[i] ?? 0));

const lineOf = (places: Places): LayerContent => ({
  kind: "path",
  style: "path",
  names: ["x", "y"],
  columns: columnsOf(places),
  edges: null,
  values: null,
});

function colouredLineOf({ estimate, errors_m }: TrajectoryErrors["paths"]): LayerContent {
  const n = Math.max(0, estimate.length - 1);
  return {
    kind: "graph",
    style: "graph",
    names: ["x", "y", "value"],
    columns: [...columnsOf(estimate), Float32Array.from(errors_m)],
    edges: Uint32Array.from({ length: 2 * n }, (_, i) => (i >> 1) + (i & 1)),
    values: Float32Array.from(errors_m.slice(0, n)),
  };
}
