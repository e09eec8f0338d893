import { useEffect } from "preact/hooks";
import type { Connection } from "../../store/connect";
import type { Store } from "../../store/store";
import type { Status } from "../../store/stream";
import { Steps } from "../../tools/steps/Steps";
import { Button } from "../../ui/Button";

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8];

const isTyping = (target: EventTarget | null): boolean =>
  target instanceof Element &&
  target.closest("input, select, button, a, summary, textarea, [role=slider], [role=application]") !== null;

/** Playback and world: play, step, restart, undo, automatic driving, speed, choice of the world. */
export function Controls({ store }: { readonly store: Store | null }) {
  const world = store?.world.value;
  const playing = store?.playing.value ?? true;
  const auto = store?.auto.value ?? true;
  const speed = store?.speed.value ?? 1;
  const off = !store?.isReady.value;
  useEffect(() => {
    const onKey = (event: KeyboardEvent): void => {
      const isUndo = (event.ctrlKey || event.metaKey) && !event.altKey && event.key.toLowerCase() === "z";
      if (isUndo && !(event.target as Element).closest?.("input:not([type=range]), textarea")) {
        event.preventDefault();
        if (event.shiftKey) store?.history.redo();
        else store?.history.undo();
        return;
      }
      if (event.key !== " " || isTyping(event.target)) return;
      event.preventDefault();
      store?.togglePlaying();
    };
    addEventListener("keydown", onKey);
    return () => removeEventListener("keydown", onKey);
  }, [store]);
  return (
    <div class="lab-controls">
      <div class="lab-buttons">
        <Button
          kind="primary"
          icon={playing ? "pause" : "play"}
          label={playing ? "Pause" : "Play"}
          disabled={off}
          onClick={() => store?.togglePlaying()}
        />
        <Steps store={store} />
        <span class="lab-break" />
        <Button
          icon="restart"
          label="Clear the map and start over"
          disabled={off}
          onClick={() => store?.send({ type: "restart" })}
        />
        <Button
          icon="undo"
          label="Undo (Ctrl+Z)"
          disabled={!store?.history.canUndo.value}
          onClick={() => store?.history.undo()}
        />
        <Button
          icon="redo"
          label="Redo (Ctrl+Shift+Z)"
          disabled={!store?.history.canRedo.value}
          onClick={() => store?.history.redo()}
        />
        <Button icon="robot" pressed={auto} disabled={off} onClick={() => store?.send({ type: "auto", value: !auto })}>
          Auto-drive
        </Button>
      </div>
      <label class="lab-choice">
        <span>Speed</span>
        <select
          class="select"
          disabled={off}
          value={String(speed)}
          onChange={(event) => store?.send({ type: "speed", value: Number(event.currentTarget.value) })}
        >
          {SPEEDS.map((one) => (
            <option key={one} value={String(one)} selected={one === speed}>
              {one}×
            </option>
          ))}
        </select>
      </label>
      <label class="lab-choice">
        <span>World</span>
        <select
          class="select"
          disabled={!world}
          value={world?.name ?? ""}
          onChange={(event) => store?.chooseWorld(event.currentTarget.value)}
        >
          {(world?.names ?? [""]).map((name) => (
            <option key={name} value={name} selected={name === world?.name}>
              {name === world?.name ? (world.title ?? name) : titled(name)}
            </option>
          ))}
        </select>
      </label>
    </div>
  );
}

const titled = (name: string): string => name.charAt(0).toUpperCase() + name.slice(1).replaceAll("_", " ");

const STATUS_LABELS: Readonly<Record<Status, string>> = {
  connecting: "connecting",
  live: "live",
  reconnecting: "reconnecting",
  away: "paused",
  gone: "ended",
  outdated: "outdated",
};

/** The state of the connection to the session, or its error. */
export function Connected({ connection }: { readonly connection: Connection | null }) {
  const now = connection?.status.value ?? "connecting";
  return (
    <span class={`lab-status ${now}`} role="status">
      {connection?.trouble.value ?? STATUS_LABELS[now]}
    </span>
  );
}
