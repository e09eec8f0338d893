import { useSignal, useSignalEffect } from "@preact/signals";
import type { ComponentChildren } from "preact";
import type { Picture } from "../../render/picture/Picture";
import type { Connection } from "../../store/connect";
import { Toolbar, ToolHint } from "../../tools/editing/Toolbar";
import { readable } from "../../tools/parameters/parameters";
import { BeliefView } from "../../tools/picture/BeliefView";
import { ComputingMap } from "../../tools/picture/ComputingMap";
import { WorldView } from "../../tools/picture/WorldView";
import { PlaceRobot, PlacingHint } from "../../tools/placing/Placing";
import { Readout } from "../../tools/readout/Readout";
import { Button } from "../../ui/Button";
import { lazy } from "../../ui/lazy";
import { isDark, printing } from "../../ui/theme";
import type { Parameter, Values } from "../../wire/protocol";

const Beside = lazy(async () => (await import("../../tools/picture/SecondMapView")).SecondMapView);

/** The connection to a session, with its id. */
export interface Live extends Connection {
  readonly id: string;
}

interface PicturesProps {
  readonly session: Live | null;
  /** Called with the picture of the map. */
  readonly onPicture: (picture: Picture) => void;
}

const clampTitle = (values: Values): string => (values.clamp === true ? "With the clamp" : "Without the clamp");

/** The parameters of the second map that differ, with the labels of the parameter panel. */
function difference(values: Values, table: readonly Parameter[]): string {
  const parts = Object.entries(values).map(([name, value]) => {
    const row = table.find((one) => one.name === name);
    const text = typeof value === "boolean" ? (value ? "on" : "off") : readable(String(value));
    return `${row?.label ?? readable(name)}: ${text}${row?.unit ? ` ${row.unit}` : ""}`;
  });
  return ["True poses, all returns", ...parts].join(" · ");
}

interface PlateProps {
  readonly title: string;
  readonly note: string;
  readonly actions?: ComponentChildren;
  readonly caption: ComponentChildren;
  readonly children: ComponentChildren;
}

/** A picture with a title above it and a caption below it. */
function Plate({ title, note, actions, caption, children }: PlateProps) {
  return (
    <section class="plate" aria-label={title}>
      <header class="plate-head">
        <div class="plate-title">
          <h2>{title}</h2>
          <span class="plate-note">{note}</span>
        </div>
        {actions}
      </header>
      <div class="plate-picture">{children}</div>
      <div class="plate-caption">{caption}</div>
    </section>
  );
}

/** The 3D scene of the session in an iframe, in the colour scheme of this page. */
function Scene({ session }: { readonly session: string }) {
  const dark = useSignal(isDark.peek());
  useSignalEffect(() => {
    if (!printing.value) dark.value = isDark.value;
  });
  const query = dark.value ? "?darkMode" : "";
  return <iframe class="scene" title="3D view" src={`/scenes/${encodeURIComponent(session)}/${query}`} />;
}

export function Pictures({ session, onPicture }: PicturesProps) {
  const store = session?.store ?? null;
  const solid = useSignal(false);
  const compared = store?.compared.value ?? null;
  const fit = (): void => {
    if (store) store.viewHeld.value = false;
  };
  return (
    <div class={`plates${solid.value || compared ? " three" : ""}`}>
      <Plate
        title="The world"
        note="ground truth"
        actions={
          <>
            {store && <PlaceRobot store={store} />}
            {store && <Toolbar store={store} />}
            <Button kind="quiet" icon="fit" label="Show everything" onClick={fit} />
          </>
        }
        caption={
          store && (
            <>
              <PlacingHint store={store} />
              <ToolHint store={store} />
            </>
          )
        }
      >
        {store && <WorldView store={store} />}
      </Plate>
      <Plate
        title="The belief"
        note="the map of the robot"
        actions={
          <Button
            kind="quiet"
            icon="cube"
            pressed={solid.value}
            disabled={!session}
            onClick={() => {
              solid.value = !solid.value;
              if (solid.value && compared) store?.send({ type: "compare", values: null });
            }}
          >
            3D
          </Button>
        }
        caption={store ? <Readout store={store} /> : null}
      >
        {store && <BeliefView store={store} onPicture={(picture) => onPicture(picture)} />}
        {store && <ComputingMap store={store} />}
      </Plate>
      {compared && session && store && (
        <Plate
          title={compared.with_faults ? clampTitle(compared.values) : "Correct map"}
          note="from the same readings"
          actions={
            <Button
              kind="quiet"
              icon="close"
              label="Close the second map"
              onClick={() => store.send({ type: "compare", values: null })}
            />
          }
          caption={
            <p class="hint">
              {compared.with_faults
                ? "Only the clamp differs."
                : difference(compared.values, store.hello.value?.parameters.table ?? [])}
            </p>
          }
        >
          <Beside store={store} />
        </Plate>
      )}
      {solid.value && !compared && session && (
        <Plate
          title="In 3D"
          note="map, robot and world"
          actions={
            <Button
              kind="quiet"
              icon="close"
              label="Close 3D"
              onClick={() => {
                solid.value = false;
              }}
            />
          }
          caption={
            <p class="hint">
              <a href={`/3d?session=${encodeURIComponent(session.id)}`} target="_blank" rel="noopener">
                Open in a new tab
              </a>
            </p>
          }
        >
          <Scene session={session.id} />
        </Plate>
      )}
    </div>
  );
}
