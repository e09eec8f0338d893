import { effect, signal, useSignal, useSignalEffect } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { bayesFilter } from "../../grid/textbook";
import type { Size } from "../../render/view";
import type { Store } from "../../store/store";
import type { Walk } from "../../store/walk";
import { Button } from "../../ui/Button";
import { signed, written } from "../../ui/numbers";
import { key } from "./model";
import { endStaleWalk, step, UNITS, type Unit, valuesNow } from "./stepping";
import { viewWithCell, zoomedInScale } from "./zoomToCell";
import "./steps.css";

const unit = signal<Unit>("scan");

/** Back and on by a cell, a beam, a scan or a second. */
export function Steps({ store }: { readonly store: Store | null }) {
  const off = !store?.isReady.value;
  useEffect(() => (store ? endStaleWalk(store) : undefined), [store]);
  const go = (by: 1 | -1): void => {
    if (store) void step(store, unit.peek(), by);
  };
  return (
    <>
      <Button icon="stepBack" label={`Back one ${unit.value}`} disabled={off} onClick={() => go(-1)} />
      <Button icon="stepForward" label={`Forward one ${unit.value}`} disabled={off} onClick={() => go(1)} />
      <select
        class="select steps-unit"
        aria-label="Step size"
        disabled={off}
        value={unit.value}
        onChange={(event) => {
          unit.value = event.currentTarget.value as Unit;
        }}
      >
        {UNITS.map((one) => (
          <option key={one} value={one} selected={one === unit.value}>
            {one}
          </option>
        ))}
      </select>
    </>
  );
}

/** What the step of the moment did, in numbers: the beam, the cell, Bresenham's error term, the update. */
export function StepNote({ store }: { readonly store: Store }) {
  const walk = store.walk.value;
  void store.inspected.value;
  void store.mapVersion.value;
  if (!walk) return null;
  return (
    <div class="steps-note">
      <p role="status">{walk.done === 0 ? beginning(walk) : <Told store={store} walk={walk} />}</p>
      <Closely store={store} />
    </div>
  );
}

/** The size that every picture of the view has at least. */
const smallest = (sizes: readonly Size[]): Size => ({
  width: Math.min(...sizes.map(({ width }) => width)),
  height: Math.min(...sizes.map(({ height }) => height)),
});

/** Brings both pictures near to the cell of the moment, and gives back what they showed when it or the walk is over. */
function Closely({ store }: { readonly store: Store }) {
  const isOn = useSignal(false);
  useSignalEffect(() => {
    if (!isOn.value) return;
    const before = store.viewHeld.peek() ? store.view.peek() : null;
    let isFirst = true;
    const stop = effect(() => {
      const walk = store.walk.value;
      const view = store.view.peek();
      const now = walk?.steps[Math.max(0, walk.done - 1)];
      if (!walk || !view || !now) return;
      const near = isFirst ? { ...view, scale: zoomedInScale(walk.geometry) } : view;
      isFirst = false;
      store.look(viewWithCell(near, smallest([...store.pictures.values()]), walk.geometry, now.cell));
    });
    return () => {
      stop();
      if (before) store.look(before);
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

const beginning = ({ steps, frame }: Walk): string =>
  `The newest scan was taken out of the map: ${frame.ranges.length} beams, ${steps.length} cells to update.`;

function Told({ store, walk }: { readonly store: Store; readonly walk: Walk }) {
  const now = walk.steps[walk.done - 1];
  if (!now) return null;
  const held = (done: number): number | undefined => valuesNow(store, { ...walk, done }).get(key(now.cell));
  const after = held(walk.done) ?? 0;
  const before = [...walk.steps.slice(0, walk.done - 1)].some((one) => key(one.cell) === key(now.cell))
    ? (held(walk.done - 1) ?? 0)
    : undoneOf(store, walk, after);
  const sum = bayesFilter(before, now.evidence, { ...walk.config, clamp: false });
  const clamped = Math.abs(sum - after) > 1e-4;
  return (
    <>
      <span>
        Beam <b>{now.beam + 1}</b> of {walk.frame.ranges.length}, cell <b>{now.place + 1}</b> of {now.of}.
      </span>{" "}
      <span>
        {now.nabla === null
          ? "Bresenham ends here."
          : `Error term ∇ ${signed(now.nabla, 0)}: ${now.nabla >= 0 ? "not below 0, so the next cell is a diagonal one on" : "below 0, so straight on"}.`}
      </span>{" "}
      <span class={now.isHit ? "noun-hit" : "noun-miss"}>
        {now.isHit ? "Hit" : "Passed"}: {signed(before)} {now.evidence < 0 ? "−" : "+"}{" "}
        {written(Math.abs(now.evidence), 2)} = {clamped && `${signed(sum)}, clamped to `}
        <b>{signed(after)}</b>.
      </span>
    </>
  );
}

/** What a cell that this step touched for the first time held before it: what lies beneath. */
function undoneOf(store: Store, walk: Walk, after: number): number {
  const now = walk.steps[walk.done - 1];
  if (!now) return after;
  const one = { ...walk, steps: [{ ...now, evidence: 0 }], done: 1 };
  return valuesNow(store, one).get(key(now.cell)) ?? after;
}
