/** The clip box of a 3D map, outside of which nothing is drawn. */

import { Button } from "../../ui/Button";
import { Panel } from "../../ui/Panel";
import { Slider } from "../../ui/Slider";
import type { Parameter } from "../../wire/protocol";
import type { Look } from "./useLook";

/** The names of the least and the greatest coordinate along each axis. */
const AXES = [
  ["cut_x_low", "cut_x_high"],
  ["cut_y_low", "cut_y_high"],
  ["cut_low", "cut_high"],
] as const;

const within = ({ low, high }: Parameter, value: number): number => Math.min(high, Math.max(low, value));

/** Two sliders for each axis, which cannot pass each other. */
export function ClipBox({ look: { rows, values, set, setAll } }: { readonly look: Look }) {
  const row = (name: string): Parameter | undefined => rows.find((row) => row.name === name);
  const ends = AXES.flatMap(([low, high]) => {
    const [from, to] = [row(low), row(high)];
    return from && to ? [[from, from.low] as const, [to, to.high] as const] : [];
  });
  const isWhole = ends.every(([end, whole]) => within(end, Number(values.value[end.name])) === whole);
  return (
    <Panel title="Clip box">
      {AXES.map((names) => {
        const [low, high] = names.map(row);
        if (!low || !high) return null;
        const [from, to] = [within(low, Number(values.value[low.name])), within(high, Number(values.value[high.name]))];
        return [low, high].map((end) => (
          <Slider
            key={end.name}
            label={end.label}
            sentence={end.sentence}
            unit={end.unit}
            low={end === low ? end.low : from}
            high={end === low ? to : end.high}
            step={end.step}
            value={end === low ? from : to}
            initial={within(end, Number(end.initial))}
            onInput={(value) => set(end.name, value)}
          />
        ));
      })}
      <div class="actions">
        <Button
          icon="fit"
          disabled={isWhole}
          onClick={() => setAll(Object.fromEntries(ends.map(([end, whole]) => [end.name, whole])))}
        >
          Draw the whole map
        </Button>
      </div>
    </Panel>
  );
}

/** Switches the handles on the faces of the box in the view. */
export function ClipHandles({ look: { values, set } }: { readonly look: Look }) {
  const areShown = values.value.cut_handles === true;
  return (
    <Button icon="box" pressed={areShown} onClick={() => set("cut_handles", !areShown)}>
      Clip
    </Button>
  );
}
