import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { Button } from "./Button";
import { NumberField } from "./NumberField";

interface PlaceFormProps {
  /** What the button says. */
  readonly label: string;
  readonly onPlace: (place: readonly [number, number, number]) => void;
}

/** The coordinates of a place in 3D, for a keyboard. */
export function PlaceForm({ label, onPlace }: PlaceFormProps) {
  const id = useId();
  const place = useSignal<readonly [number, number, number]>([0, 0, 0]);
  return (
    <form
      class="place-form"
      onSubmit={(event) => {
        event.preventDefault();
        onPlace(place.peek());
      }}
    >
      {([0, 1, 2] as const).map((axis) => (
        <div key={axis}>
          <label for={id + axis}>{"xyz"[axis]} (m)</label>
          <NumberField
            id={id + axis}
            class="field-text"
            step={0.01}
            value={place.value[axis]}
            onChange={(value) => {
              const next: [number, number, number] = [...place.peek()];
              next[axis] = value;
              place.value = next;
            }}
          />
        </div>
      ))}
      <Button submits>{label}</Button>
    </form>
  );
}
