/** The comparison of a log's map with another map: choice of the other map, display, and measures of the difference. */

import { useSignal, useSignalEffect } from "@preact/signals";
import { Fragment } from "preact";
import type { Store } from "../../../store/store";
import { BLINK_S, type Comparison, VIEW_MODES, type ViewMode } from "../../../tools/compare/comparison";
import { Legend } from "../../../tools/compare/Legend";
import { Numbers } from "../../../tools/compare/Numbers";
import { FileButton } from "../../../tools/files/FileButton";
import { Button } from "../../../ui/Button";
import { selected } from "../../../ui/bound";
import { Choice } from "../../../ui/Choice";
import { Panel } from "../../../ui/Panel";
import { ToggleOf } from "../../../ui/Toggle";
import type { ComparedMap } from "../../../wire/http";
import type { Compared, LogInfo } from "../../../wire/protocol";
import { LogChoice } from "../LogChoice";
import { trajectoryLabel } from "../library/describeLog";
import { compareWith, differing, endComparison, type Kind, kindOf } from "./sides";

interface CompareProps {
  readonly store: Store;
  readonly session: string;
  readonly comparison: Comparison;
  /** A visitor with a shared link sees no other logs. */
  readonly isGuest: boolean;
}

const TITLES: Record<ViewMode, string> = { swipe: "Swipe", blink: "Blink", difference: "Difference", merge: "Merge" };

export function Compare({ store, session, comparison, isGuest }: CompareProps) {
  const failure = useSignal<string | null>(null);
  const busy = useSignal(false);
  const wish = useSignal<Kind>("settings");
  useSignalEffect(() => {
    // A link or another visitor can also make the choice.
    const now = store.compared.value;
    if (now) wish.value = kindOf(now);
  });
  const compared = store.compared.value;
  const hello = store.hello.value;
  if (!hello) return null;
  const ask = async (what: () => Promise<string | null>): Promise<void> => {
    busy.value = true;
    failure.value = await what();
    busy.value = false;
  };
  const begin = (other: ComparedMap): void => void ask(() => compareWith(session, other));
  const kind = wish.value;
  const trajectory = store.trajectory.value?.name ?? hello.log?.trajectory ?? "";
  const others = (hello.log?.trajectories ?? []).filter((other) => other.name !== trajectory);
  const options: { value: Kind; label: string }[] = [
    { value: "settings", label: "Saved settings" },
    ...(others.length > 0 ? [{ value: "poses" as const, label: "Other poses" }] : []),
    ...(isGuest ? [] : [{ value: "log" as const, label: "Another log" }]),
  ];
  return (
    <div class="viewer-compare">
      <Panel title="Compare" note={!compared && "this map, B, with another map, A"}>
        <div class="compare">
          <div class="stack">
            <Choice
              label="A is"
              options={options}
              value={kind}
              onChange={(value) => {
                wish.value = value;
                failure.value = null;
              }}
            />
            {kind === "settings" && (
              <>
                <p class="quiet">A keeps the current settings; the sliders change B.</p>
                <div class="actions">
                  <Button
                    kind={compared ? undefined : "primary"}
                    disabled={busy.value}
                    onClick={() => begin({ values: store.mapping.values.peek(), trajectory })}
                  >
                    Save as A
                  </Button>
                </div>
              </>
            )}
            {kind === "poses" && <Poses others={others} compared={compared} disabled={busy.value} onChoose={begin} />}
            {kind === "log" && (
              <Logs own={hello.log?.id ?? ""} compared={compared} disabled={busy.value} onChoose={begin} />
            )}
            {failure.value !== null && (
              <p class="compare-failed" role="alert">
                {failure.value}
              </p>
            )}
            {compared && <Sides store={store} compared={compared} />}
          </div>
          {compared && (
            <>
              <div class="compare-mode stack">
                <Choice
                  label="Show as"
                  options={VIEW_MODES.map((mode) => ({ value: mode, label: TITLES[mode] }))}
                  {...selected(comparison.mode)}
                />
                {comparison.mode.value === "swipe" && (
                  <p class="quiet">Drag the divider, or move it with the arrow keys.</p>
                )}
                {comparison.mode.value === "blink" && <Blinking comparison={comparison} />}
                {comparison.mode.value === "difference" && <Legend comparison={comparison} />}
                {comparison.mode.value === "merge" && <Merge compared={compared} />}
                <div class="actions">
                  <FileButton session={session} file="compare.png">
                    Difference (png)
                  </FileButton>
                  <Button icon="close" onClick={() => void ask(() => endComparison(session))}>
                    End comparison
                  </Button>
                </div>
              </div>
              <Numbers
                comparison={comparison}
                numbers={store.part("comparison").message.value?.numbers ?? null}
                refused={store.part("comparison").message.value?.refused ?? null}
                onGo={(place) => {
                  store.pinned.value = place;
                  const view = store.view.peek();
                  if (view) store.setView({ x: place[0], y: place[1], scale: Math.min(view.scale, 0.01) });
                }}
              />
            </>
          )}
        </div>
      </Panel>
    </div>
  );
}

interface ChooseProps {
  readonly compared: Compared | null;
  readonly disabled: boolean;
  readonly onChoose: (other: ComparedMap) => void;
}

function Poses({ others, compared, disabled, onChoose }: ChooseProps & { readonly others: LogInfo["trajectories"] }) {
  const now = compared && kindOf(compared) === "poses" ? compared.trajectory : undefined;
  return (
    <>
      <p class="quiet">A is the same log with other poses; both use the same settings.</p>
      <div class="actions">
        {others.map((other) => (
          <Button
            key={other.name}
            pressed={other.name === now}
            disabled={disabled}
            onClick={() => onChoose({ trajectory: other.name })}
          >
            {trajectoryLabel(other.name)}
          </Button>
        ))}
      </div>
    </>
  );
}

function Logs({ own, compared, disabled, onChoose }: ChooseProps & { readonly own: string }) {
  return (
    <>
      <p class="quiet">
        A is another log, complete, with the settings of this one. The maps can be compared only if the poses of both
        logs are in the same frame.
      </p>
      <LogChoice
        own={own}
        chosen={compared?.log ? { log: compared.log, topic: compared.topic ?? null } : null}
        disabled={disabled}
        onChoose={onChoose}
      />
    </>
  );
}

/** The parameters in which A and B differ, and a button that sets B to A. */
function Sides({ store, compared }: { readonly store: Store; readonly compared: Compared }) {
  const table = store.hello.value?.parameters.table ?? [];
  const rows = differing(table, compared, store.mapping.values.value);
  const isKept = Object.keys(compared.values).length > 0;
  if (!isKept) return null;
  if (rows.length === 0) {
    return <p class="quiet">A and B have the same settings. Move a slider to change B.</p>;
  }
  return (
    <>
      <dl class="compare-differing" aria-label="Settings in which A and B differ">
        <dt class="quiet">setting</dt>
        <dd class="quiet">A</dd>
        <dd class="quiet">B</dd>
        {rows.map((row) => (
          <Fragment key={row.name}>
            <dt>{row.label}</dt>
            <dd>{row.a}</dd>
            <dd>{row.b}</dd>
          </Fragment>
        ))}
      </dl>
      <div class="actions">
        <Button
          icon="undo"
          onClick={() =>
            store.setTogether(
              "compare back",
              Object.fromEntries(rows.map(({ name }) => [name, compared.values[name] ?? 0])),
            )
          }
        >
          Set B to the settings of A
        </Button>
      </div>
    </>
  );
}

/** Explains the merged map, and when its evidence is independent. */
function Merge({ compared }: { readonly compared: Compared }) {
  return (
    <p class="quiet">
      The evidence of both maps added: in each cell ℓ = ℓ<sub>A</sub> + ℓ<sub>B</sub> − ℓ₀, shown within the limits of
      B.{" "}
      {compared.log
        ? "Meant for two runs through the same place."
        : "Both maps are of the same scans, so each scan counts twice: merge maps of two runs instead."}
    </p>
  );
}

function Blinking({ comparison }: { readonly comparison: Comparison }) {
  return (
    <>
      <ToggleOf label="Automatic" signal={comparison.blinks} />
      {comparison.blinks.value && (
        <Choice
          label="Seconds per map"
          options={BLINK_S.map((seconds) => ({ value: String(seconds), label: String(seconds) }))}
          value={String(comparison.blinkS.value)}
          onChange={(seconds) => {
            comparison.blinkS.value = Number(seconds);
          }}
        />
      )}
      <Button onClick={() => comparison.turn()}>Show {comparison.shown.value === "a" ? "B" : "A"} (key B)</Button>
    </>
  );
}
