import type { Store } from "../../../store/store";
import { Panel } from "../../../ui/Panel";

const AXES = ["z", "-z", "y", "-y", "x", "-x"];

interface UpChoiceProps {
  readonly store: Store;
  readonly onUp: (axis: string) => void;
}

/** The axis of the file that points up: depth cameras and scanners often have another one than z. */
export function UpChoice({ store, onUp }: UpChoiceProps) {
  const now = store.part("volume").message.value;
  if (!now?.has_scans) return null;
  return (
    <Panel title="Up">
      <label class="field">
        <span class="field-label">Axis of the file that points up</span>
        <select class="select" value={now.up} onChange={(event) => onUp(event.currentTarget.value)}>
          {AXES.map((axis) => (
            <option key={axis} value={axis}>
              {axis.replace("-", "−")}
            </option>
          ))}
        </select>
      </label>
      <p class="quiet">The map is opened again, turned.</p>
    </Panel>
  );
}
