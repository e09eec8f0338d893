import { useEffect } from "preact/hooks";
import type { Connection } from "../../store/connect";
import type { Store } from "../../store/store";
import type { Status } from "../../store/stream";
import { StepButtons } from "../../tools/steps/Steps";
import { Button } from "../../ui/Button";
import { isTyping } from "../../ui/browser/isTyping";
import { Select } from "../../ui/Select";

/** Undo and redo by Ctrl+Z, play and pause by the space bar. */
function useKeys(store: Store | null): void {
  useEffect(() => {
    const onKey = (event: KeyboardEvent): void => {
      const isUndo = (event.ctrlKey || event.metaKey) && !event.altKey && event.key.toLowerCase() === "z";
      if (isUndo && !(event.target as Element).closest?.("input:not([type=range]), textarea")) {
        event.preventDefault();
        if (event.shiftKey) store?.history.redo();
        else store?.history.undo();
        return;
      }
      if (event.key !== " " || isTyping(event.target, "application", "tabpanel")) return;
      event.preventDefault();
      store?.togglePlaying();
    };
    addEventListener("keydown", onKey);
    return () => removeEventListener("keydown", onKey);
  }, [store]);
}

/** The first controls: play, step, reset, and the choice of the world. */
export function Controls({ store }: { readonly store: Store | null }) {
  useKeys(store);
  const world = store?.world.value;
  const playing = store?.playing.value ?? true;
  const off = !store?.isReady.value;
  return (
    <div class="lab-controls">
      <Button
        kind="primary"
        icon={playing ? "pause" : "play"}
        label={playing ? "Pause" : "Play"}
        disabled={off}
        onClick={() => store?.togglePlaying()}
      />
      <StepButtons store={store} />
      <Button
        icon="restart"
        disabled={off}
        onClick={() => {
          store?.reset();
          store?.send({ type: "restart" });
        }}
      >
        <span class="lab-reset">Reset</span>
      </Button>
      <label class="lab-choice">
        <span>World</span>
        <Select
          disabled={!world}
          value={world?.name ?? ""}
          options={(world?.names ?? [""]).map((name) => ({
            value: name,
            label: name === world?.name ? (world.title ?? name) : titled(name),
          }))}
          onChange={(name) => store?.chooseWorld(name)}
        />
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
  const trouble = connection?.trouble.value ?? null;
  // A server that keeps the connection but does not answer is treated as one to which the page reconnects repeatedly.
  const shown = now === "live" && trouble !== null ? "reconnecting" : now;
  return (
    <span class={`lab-status ${shown}`} role="status">
      {trouble ?? STATUS_LABELS[now]}
    </span>
  );
}
