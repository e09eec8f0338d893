import { effect, signal, useSignal, useSignalEffect } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { bayesFilter } from "../../grid/textbook";
import type { Size, View } from "../../render/view";
import type { Stepping } from "../../store/sessionSignals";
import type { Store } from "../../store/store";
import { Button } from "../../ui/Button";
import { selected } from "../../ui/bound";
import { Choice } from "../../ui/Choice";
import { signed, written } from "../../ui/numbers";
import { key } from "./model";
import { endStaleSteps, step, UNITS, type Unit, valuesNow } from "./stepping";
import "./steps.css";
import { type Cell, centreOf } from "../../grid/lattice";
import type { Geometry } from "../../wire/protocol";

/** Width of a cell in the zoomed-in view, pixels. */
const CELL_PX = 16;
/** The view does not move while the cell is in this central fraction of the picture. */
const CENTRAL = 0.7;

/** Metres per pixel of the zoomed-in view. */
export const zoomedInScale = (geometry: Geometry): number => geometry.resolution / CELL_PX;

/** A view that contains a cell: the current one if the cell is well inside, otherwise centred on the cell. */
export function viewWithCell(view: View, size: Size, geometry: Geometry, cell: Cell): View {
  const [x, y] = centreOf(geometry, cell);
  const reach = (CENTRAL / 2) * view.scale;
  const isInSight = Math.abs(x - view.x) <= reach * size.width && Math.abs(y - view.y) <= reach * size.height;
  return isInSight ? view : { ...view, x, y };
}

const unit = signal<Unit>("scan");

/** Buttons to step back and forward by the chosen unit. */
export function StepButtons({ store }: { readonly store: Store | null }) {
  const off = !store?.isReady.value;
  useEffect(() => (store ? endStaleSteps(store) : undefined), [store]);
  const go = (by: 1 | -1): void => {
    if (store) void step(store, unit.peek(), by);
  };
  return (
    <>
      <Button icon="stepBack" label={`Back one ${unit.value}`} disabled={off} onClick={() => go(-1)} />
      <Button icon="stepForward" label={`Forward one ${unit.value}`} disabled={off} onClick={() => go(1)} />
    </>
  );
}

const UNIT_OPTIONS = UNITS.map((unit) => ({ value: unit, label: unit }));

/** The size of a step, and the current one in numbers. */
export function Steps({ store }: { readonly store: Store }) {
  return (
    <div class="steps stack">
      <Choice label="Step size" options={UNIT_OPTIONS} {...selected(unit)} />
      {store.stepping.value ? (
        <StepNote store={store} />
      ) : (
        <p class="steps-hint">
          The step buttons above the world go back and forward by this much. By cells and beams the newest scan is added
          to the map again, with the numbers of each update.
        </p>
      )}
    </div>
  );
}

/** The current step in numbers: the beam, the cell, Bresenham's error term, the update. */
function StepNote({ store }: { readonly store: Store }) {
  const stepping = store.stepping.value;
  void store.inspected.value;
  void store.mapVersion.value;
  if (!stepping) return null;
  return (
    <div class="steps-note">
      <p role="status">{stepping.done === 0 ? startText(stepping) : <StepText store={store} stepping={stepping} />}</p>
      <ZoomToggle store={store} />
    </div>
  );
}

/** The smallest width and the smallest height of the pictures. */
const smallest = (sizes: readonly Size[]): Size => ({
  width: Math.min(...sizes.map(({ width }) => width)),
  height: Math.min(...sizes.map(({ height }) => height)),
});

/** A toggle that zooms both pictures to the current cell; the view is restored when it is off or the stepping ends. */
function ZoomToggle({ store }: { readonly store: Store }) {
  const isOn = useSignal(false);
  useSignalEffect(() => {
    if (!isOn.value) return;
    const before = store.viewHeld.peek() ? store.view.peek() : null;
    let isFirst = true;
    const stop = effect(() => {
      const stepping = store.stepping.value;
      const view = store.view.peek();
      const now = stepping?.steps[Math.max(0, stepping.done - 1)];
      if (!stepping || !view || !now) return;
      const near = isFirst ? { ...view, scale: zoomedInScale(stepping.geometry) } : view;
      isFirst = false;
      store.setView(viewWithCell(near, smallest([...store.pictures.values()]), stepping.geometry, now.cell));
    });
    return () => {
      stop();
      if (before) store.setView(before);
      else store.viewHeld.value = false;
    };
  });
  return (
    <Button
      icon="target"
      pressed={isOn.value}
      onClick={() => {
        isOn.value = !isOn.value;
      }}
    >
      Zoom in
    </Button>
  );
}

const startText = ({ steps, frame }: Stepping): string =>
  `The newest scan was removed from the map: ${frame.ranges.length} beams, ${steps.length} cells to update.`;

function StepText({ store, stepping }: { readonly store: Store; readonly stepping: Stepping }) {
  const now = stepping.steps[stepping.done - 1];
  if (!now) return null;
  const held = (done: number): number | undefined => valuesNow(store, { ...stepping, done }).get(key(now.cell));
  const after = held(stepping.done) ?? 0;
  const before = [...stepping.steps.slice(0, stepping.done - 1)].some((step) => key(step.cell) === key(now.cell))
    ? (held(stepping.done - 1) ?? 0)
    : valueBeforeFirstUpdate(store, stepping, after);
  const sum = bayesFilter(before, now.evidence, { ...stepping.config, clamp: false });
  const clamped = Math.abs(sum - after) > 1e-4;
  const outweighed = !now.isHit && now.evidence === 0 && stepping.config.log_odds_miss < 0;
  return (
    <>
      <span>
        Beam <b>{now.beam + 1}</b> of {stepping.frame.ranges.length}, cell <b>{now.place + 1}</b> of {now.of}.
      </span>{" "}
      <span>
        {now.nabla === null
          ? "Last cell of Bresenham’s line."
          : `Error term ∇ ${signed(now.nabla, 0)}: ${now.nabla >= 0 ? "not negative, so the next step is diagonal" : "negative, so the next step is straight"}.`}
      </span>{" "}
      <span class={now.isHit ? "noun-hit" : "noun-miss"}>
        {now.isHit ? "Hit" : outweighed ? "Passed, but the scan hits the cell" : "Passed"}: {signed(before)}{" "}
        {now.evidence < 0 ? "−" : "+"} {written(Math.abs(now.evidence), 2)} = {clamped && `${signed(sum)}, clamped to `}
        <b>{signed(after)}</b>.
      </span>
    </>
  );
}

/** The log-odds, before this step, of a cell that no earlier step has updated. */
function valueBeforeFirstUpdate(store: Store, stepping: Stepping, after: number): number {
  const now = stepping.steps[stepping.done - 1];
  if (!now) return after;
  const single = { ...stepping, steps: [{ ...now, evidence: 0 }], done: 1 };
  return valuesNow(store, single).get(key(now.cell)) ?? after;
}
