/** Controls over a map: fit, full screen, ruler, area, the scale, the pointer's position, and the measurement. */

import { useComputed, useSignalEffect } from "@preact/signals";
import type { ComponentChildren, RefObject } from "preact";
import { useEffect, useRef } from "preact/hooks";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { switched } from "../../ui/bound";
import { inHand } from "../../ui/browser/media";
import { SwitchChip } from "../../ui/dock/SwitchChip";
import type { IconName } from "../../ui/iconPaths";
import { written } from "../../ui/numbers";
import { PlaceForm } from "../../ui/PlaceForm";
import { measuredText, scaleBar, scaleText } from "./model";
import "./measure.css";
import { type Measuring as MeasuringState, type MeasuringTool, measuringOf } from "./measuring";
import { measureInScenes } from "./tool";

const TOOLS: readonly (readonly [tool: MeasuringTool, icon: IconName, label: string])[] = [
  ["distance", "ruler", "Measure a distance"],
  ["area", "area", "Measure an area"],
];

interface MapToolsProps {
  readonly store: Store;
  /** The element that fills the screen. */
  readonly stage: RefObject<HTMLElement | null>;
}

export function MapTools({ store, stage }: MapToolsProps) {
  const toggleFullScreen = (): void => {
    if (document.fullscreenElement) void document.exitFullscreen();
    else void stage.current?.requestFullscreen().catch(() => undefined);
  };
  return (
    <>
      <div class="map-tools" role="toolbar" aria-label="Map tools">
        <Button
          kind="quiet"
          icon="target"
          label="Fit the map (0)"
          onClick={() => {
            store.viewHeld.value = false;
          }}
        />
        <Button kind="quiet" icon="fit" label="Full screen" onClick={toggleFullScreen} />
        <MeasuringButtons store={store} />
      </div>
      <Measuring store={store} />
    </>
  );
}

/** The buttons that select and deselect the ruler and the area. */
export function MeasuringButtons({ store }: { readonly store: Store }) {
  const measuring = measuringOf(store);
  measureInScenes(store);
  return (
    <>
      {TOOLS.map(([name, icon, label]) => (
        <Button
          key={name}
          kind="quiet"
          icon={icon}
          label={label}
          pressed={measuring.tool.value === name}
          onClick={() => measuring.take(measuring.tool.peek() === name ? null : name)}
        />
      ))}
    </>
  );
}

/** Over the map: the measurement, the scale, and the pointer's position. */
export function Measuring({ store }: { readonly store: Store }) {
  const tool = measuringOf(store).tool.value;
  return (
    <>
      {tool && <Measured store={store} tool={tool} />}
      <Place store={store} />
    </>
  );
}

/** Over a 3D view: the measurement, and coordinates for measuring by keyboard. */
export function MeasuringIn3d({ store, snaps }: { readonly store: Store; readonly snaps: boolean }) {
  const measuring = measuringOf(store);
  const tool = measuring.tool.value;
  if (!tool) return null;
  return (
    <Measured store={store} tool={tool} snaps={snaps}>
      <details class="measured-place">
        <summary>Enter a place</summary>
        <PlaceForm label="Add" onPlace={(place) => measuring.add(place, measuring.size.peek() ?? 0)} />
      </details>
    </Measured>
  );
}

/** Whether this view announces changes of the measurement to screen readers; only one of the views does. */
function useSaid({ said }: MeasuringState): boolean {
  const own = useRef({}).current;
  useSignalEffect(() => {
    said.value ??= own;
  });
  useEffect(
    () => () => {
      if (said.peek() === own) said.value = null;
    },
    [said],
  );
  return said.value === own;
}

interface MeasuredProps {
  readonly store: Store;
  readonly tool: MeasuringTool;
  /** Whether the map has walls to snap to. */
  readonly snaps?: boolean;
  readonly children?: ComponentChildren;
}

function Measured({ store, tool, snaps = true, children }: MeasuredProps) {
  const measuring = measuringOf(store);
  const points = measuring.points.value;
  const size = measuring.size.value ?? store.map.value?.geometry.resolution ?? 0;
  const isSaid = useSaid(measuring);
  return (
    <section class="measured" aria-label="Measured">
      <p class="number" {...(isSaid ? { role: "status" } : {})}>
        {inHand(measuredText(tool, points, size))}
      </p>
      <div class="measured-actions">
        {snaps && <SwitchChip label="Snap to walls" {...switched(measuring.snaps)} />}
        <Button
          kind="quiet"
          icon="undo"
          label="Remove the last point (Backspace)"
          disabled={points.length === 0}
          onClick={() => measuring.undo()}
        />
        <Button
          kind="quiet"
          icon="check"
          label="End this line"
          disabled={points.length < 2 || measuring.isDone.value}
          onClick={() => {
            measuring.isDone.value = true;
          }}
        />
        <Button kind="quiet" icon="close" label="Close the ruler" onClick={() => measuring.take(null)} />
      </div>
      {children}
    </section>
  );
}

const BAR_PX = 120;

/** The scale of the map, and the position of the pointer or the cell cursor in metres of the map's frame. */
function Place({ store }: { readonly store: Store }) {
  const scale = useComputed(() => store.view.value?.scale ?? 0);
  const at = useComputed(() => {
    const point = store.pointer.value ?? store.pinned.value;
    return point ? `x ${written(point[0], 2)}  y ${written(point[1], 2)} m` : "";
  });
  const frame = useComputed(() => store.trajectory.value?.frame ?? "");
  if (scale.value <= 0) return null;
  const length = scaleBar(scale.value, BAR_PX);
  return (
    <div class="map-place" aria-hidden="true">
      <span class="map-scale" style={{ width: `${length / scale.value}px` }}>
        {scaleText(length)}
      </span>
      {at.value && (
        <span class="map-point number">
          {at.value} {frame.value && <span class="quiet">{frame.value}</span>}
        </span>
      )}
    </div>
  );
}
