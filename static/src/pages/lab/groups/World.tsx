import type { Store } from "../../../store/store";
import { Toolbar } from "../../../tools/editing/Toolbar";
import { PlaceRobot } from "../../../tools/placing/Placing";
import { Button } from "../../../ui/Button";
import { Choice } from "../../../ui/Choice";

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8].map((speed) => ({ value: String(speed), label: `${speed}×` }));

/** What changes the world and how the robot goes through it. */
export function WorldGroup({ store }: { readonly store: Store }) {
  const off = !store.isReady.value;
  const auto = store.auto.value;
  return (
    <div class="lab-world">
      <h3>A click on the world</h3>
      <div class="actions">
        <PlaceRobot store={store} />
        <Toolbar store={store} />
      </div>
      <div class="actions">
        <Button icon="undo" disabled={!store.history.canUndo.value} onClick={() => store.history.undo()}>
          Undo
        </Button>
        <Button icon="redo" disabled={!store.history.canRedo.value} onClick={() => store.history.redo()}>
          Redo
        </Button>
      </div>
      <h3>The robot</h3>
      <div class="actions">
        <Button icon="robot" pressed={auto} disabled={off} onClick={() => store.send({ type: "auto", value: !auto })}>
          Auto-drive
        </Button>
      </div>
      <Choice
        label="Speed"
        options={SPEEDS}
        value={String(store.speed.value)}
        disabled={off}
        onChange={(speed) => store.send({ type: "speed", value: Number(speed) })}
      />
    </div>
  );
}
