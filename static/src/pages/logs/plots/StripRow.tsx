import type { ComponentProps } from "preact";
import { lazy } from "../../../ui/lazy";
import type { Strip as StripOf } from "./Strip";
import { type Shown, valueText } from "./strips";
import "./plots.css";

/** A low plot over time. uPlot is loaded when the first one is shown. */
const Strip = lazy(async () => (await import("./Strip")).Strip);

/** Colour roles: the robot's motion, its readings, the clock. */
const TONES: Record<string, string> = { returns: "--miss", interval: "--foreground-soft" };

interface StripRowProps extends Omit<ComponentProps<typeof StripOf>, "tone" | "shown"> {
  /** The range of its axis; null without values. */
  readonly shown: Shown | null;
  /** The value at the cursor; null or undefined for none. */
  readonly value: number | null | undefined;
}

/** A plot with its name and its value at the cursor on the left. */
export function StripRow({ shown, value, ...plot }: StripRowProps) {
  const { column } = plot;
  return (
    <div class="strip" data-strip={column.label}>
      <p class="strip-label">
        <strong>{column.label}</strong>
        <output>{valueText(column, value)}</output>
        {shown?.beyond != null && (
          <span class="quiet" title="Beyond the edge of the plot">
            peak {valueText(column, shown.beyond)}
          </span>
        )}
      </p>
      {shown ? (
        <Strip {...plot} shown={shown} tone={TONES[column.label] ?? "--robot"} />
      ) : (
        <p class="quiet">There are no values.</p>
      )}
    </div>
  );
}
