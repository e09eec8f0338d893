import type { Store } from "../../store/store";
import { written } from "../../ui/numbers";
import { Panel } from "../../ui/Panel";
import type { VolumeMessage } from "../../wire/protocol";
import { ParameterRows } from "../parameters/ParameterRows";
import { ClipBox } from "./ClipBox";
import { useLook } from "./useLook";

/** Names of the colourings of voxels; the others are for points. */
const OF_VOXELS = ["height", "probability", "side", "normal"];
const OF_BOTH = ["height"];
const OF_SURFACES = ["height", "normal"];

/** The display options: voxels or points, their colours, the cuts. */
export function LookGroup({ store }: { readonly store: Store }) {
  const look = useLook(store);
  const now = store.part("volume").message.value;
  if (!look || !now) return null;
  const { rows, values, set } = look;
  const { show, colour } = values.value;
  const shown = rows.flatMap((row) => {
    if (row.name.startsWith("band_") || row.name.startsWith("cut_")) return [];
    if (row.name === "point_size" && show !== "points" && show !== "both") return [];
    if (row.name === "whole" && (!now.has_free || show === "points" || show === "surface")) return [];
    if (row.name === "show") {
      const choices = row.choices.filter((choice) => choice !== "surface" || now.has_free);
      return now.has_scans ? [{ ...row, choices }] : [];
    }
    if (row.name === "band" && colour !== "height") return [];
    if (row.name === "colour") return [{ ...row, choices: coloursOf(now, String(show)) }];
    return [row];
  });
  return (
    <>
      <Panel title="What is drawn">
        <ParameterRows rows={shown} values={values} set={set} />
        <Key colour={String(colour)} show={String(show)} now={now} band={Number(values.value.band)} />
      </Panel>
      <ClipBox look={look} />
    </>
  );
}

/** The colourings for what is shown. */
export function coloursOf({ colours }: Pick<VolumeMessage, "colours">, show: string): readonly string[] {
  if (show === "surface") return OF_SURFACES;
  const ofPoints = show === "voxels" ? colours.filter((colour) => colour !== "own colour") : colours;
  return [...(show === "points" ? OF_BOTH : OF_VOXELS), ...ofPoints];
}

interface KeyProps {
  readonly colour: string;
  readonly show: string;
  readonly now: VolumeMessage;
  readonly band: number;
}

function Key({ colour, show, now, band }: KeyProps) {
  if (colour === "height") {
    const top = Math.min(now.high[2], now.low[2] + 24 * band);
    return <Ramp kind="height" from={`${written(now.low[2], 2)} m`} to={`${written(top, 2)} m and more`} />;
  }
  if (colour === "probability") return <Ramp kind="probability" from="just occupied" to="certain" />;
  if (colour === "side" || colour === "normal") {
    return (
      <p class="quiet">
        Red and green: {colour === "side" ? "sides of voxels that face" : "where the surface faces"} along x and y.
        Blue: up (light) and down.{" "}
        {colour === "normal" && show !== "surface" && "The direction is that of the plane of the voxels around."}
      </p>
    );
  }
  if (colour === "class") return <Classes />;
  return now.scale && <Scale scale={now.scale} colour={colour} />;
}

/** Text at the end of a scale. */
const ENDS: Readonly<Record<string, string>> = {
  time: " after the first",
  difference: " and more to the nearest point of the other cloud",
};

interface ScaleProps {
  readonly scale: NonNullable<VolumeMessage["scale"]>;
  readonly colour: string;
}

function Scale({ scale: { low, high, unit }, colour }: ScaleProps) {
  if (unit === "scan") return <Ramp kind="height" from={`scan ${low}`} to={`scan ${high}`} />;
  const digits = Math.min(6, Math.max(0, 2 - Math.floor(Math.log10(Math.max(high - low, 1e-6))))); // three of them
  const unitText = unit && ` ${unit}`;
  return (
    <Ramp
      kind="height"
      from={`${written(low, digits)}${unitText}`}
      to={`${written(high, digits)}${unitText}${ENDS[colour] ?? ""}`}
    />
  );
}

/** Names and colours of the classes of ASPRS LAS 1.4; the colours are those of server/parts/volume/look.py. */
const CLASSES = [
  ["not classified", "#969696"],
  ["ground", "#ac7842"],
  ["low vegetation", "#96c86e"],
  ["medium vegetation", "#60aa50"],
  ["high vegetation", "#268238"],
  ["building", "#d04a3c"],
  ["low point (noise)", "#5a3c5a"],
  ["key point", "#e6c850"],
  ["water", "#3c78d2"],
  ["rail", "#6e6e78"],
  ["road surface, or another", "#50505a"],
] as const;

function Classes() {
  return (
    <ul class="volume-classes" aria-label="Colours of the classes">
      {CLASSES.map(([name, colour]) => (
        <li key={name}>
          <span class="volume-swatch" style={{ background: colour }} aria-hidden="true" />
          {name}
        </li>
      ))}
    </ul>
  );
}

function Ramp({ kind, from, to }: { readonly kind: string; readonly from: string; readonly to: string }) {
  return (
    <div class="volume-key">
      <span class={`volume-ramp ${kind}`} aria-hidden="true" />
      <span class="volume-key-ends number">
        <span>{from}</span>
        <span>{to}</span>
      </span>
    </div>
  );
}
