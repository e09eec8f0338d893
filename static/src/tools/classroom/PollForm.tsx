import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Classroom } from "../../store/classroom";
import { Button } from "../../ui/Button";
import { selected } from "../../ui/bound";
import { Choice } from "../../ui/Choice";
import { letterOf } from "./histogram";

const MOST_OPTIONS = 8;

/** A number as it is written, with a point or a comma; null for an empty field, NaN for what is none. */
const numberIn = (text: string): number | null => (text.trim() === "" ? null : Number(text.trim().replace(",", ".")));

/** The index that the right option has among those that are not empty; null for none. */
function rightAmong(options: readonly string[], right: number): number | null {
  if (!options[right]?.trim()) return null;
  return options.slice(0, right).filter((option) => option.trim()).length;
}

/** A form for a question that is made on the spot: options to choose from, or a number to guess. */
export function PollForm({ room, isOpen }: { readonly room: Classroom; readonly isOpen: Signal<boolean> }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const kind = useSignal("options");
  const text = useSignal("");
  const options = useSignal<readonly string[]>(["Yes", "No"]);
  const low = useSignal("0");
  const high = useSignal("100");
  const unit = useSignal("");
  /** The right one of the options, −1 for none; and the right number, empty for none. */
  const rightOption = useSignal(-1);
  const rightNumber = useSignal("");
  const open = isOpen.value;
  useEffect(() => {
    if (open && !dialog.current?.open) dialog.current?.showModal();
    else if (!open) dialog.current?.close();
  }, [open]);
  const given = options.value.map((one) => one.trim()).filter(Boolean);
  const isAxis = kind.value === "number";
  const from = numberIn(low.value);
  const to = numberIn(high.value);
  const right = isAxis ? numberIn(rightNumber.value) : rightAmong(options.value, rightOption.value);
  const isReady =
    room.isConnected.value &&
    text.value.trim() !== "" &&
    (isAxis ? from !== null && to !== null && from < to && !Number.isNaN(right) : given.length >= 2);
  const ask = (): void => {
    if (!isReady) return;
    const axis = { low: from ?? 0, high: to ?? 0, unit: unit.value.trim() };
    const known = right === null ? {} : { right };
    room.send({ type: "ask", text: text.value, ...(isAxis ? { axis } : { options: given }), ...known });
    isOpen.value = false;
    text.value = rightNumber.value = "";
    rightOption.value = -1;
  };
  const change = (at: number, value: string): void => {
    options.value = options.value.map((one, i) => (i === at ? value : one));
  };
  return (
    <dialog
      class="dialog class-poll"
      ref={dialog}
      aria-labelledby="class-poll-title"
      onClose={() => {
        isOpen.value = false;
      }}
    >
      <h2 id="class-poll-title">Ask the class</h2>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          ask();
        }}
      >
        <label class="field">
          <span class="field-label">Question</span>
          <input
            class="field-text"
            maxLength={300}
            value={text.value}
            onInput={(event) => {
              text.value = event.currentTarget.value;
            }}
          />
        </label>
        <Choice
          label="Answer"
          options={[
            { value: "options", label: "One of several" },
            { value: "number", label: "A number" },
          ]}
          {...selected(kind)}
        />
        {isAxis ? (
          <div class="class-axis-fields">
            {(
              [
                ["From", low],
                ["To", high],
                ["Unit", unit],
                ["Right (if any)", rightNumber],
              ] as const
            ).map(([label, value]) => (
              <label class="field" key={label}>
                <span class="field-label">{label}</span>
                <input
                  class="field-text"
                  inputMode={label === "Unit" ? "text" : "decimal"}
                  maxLength={30}
                  value={value.value}
                  onInput={(event) => {
                    value.value = event.currentTarget.value;
                  }}
                />
              </label>
            ))}
          </div>
        ) : (
          <>
            {options.value.map((option, i) => (
              <div class="class-poll-option" key={i}>
                <label class="field">
                  <span class="field-label">Option {letterOf(i)}</span>
                  <input
                    class="field-text"
                    maxLength={300}
                    value={option}
                    onInput={(event) => change(i, event.currentTarget.value)}
                  />
                </label>
                <Button
                  pressed={rightOption.value === i}
                  icon="check"
                  label={`Mark ${letterOf(i)} as right`}
                  onClick={() => {
                    rightOption.value = rightOption.peek() === i ? -1 : i;
                  }}
                />
              </div>
            ))}
            {options.value.length < MOST_OPTIONS && (
              <Button
                kind="quiet"
                icon="plus"
                onClick={() => {
                  options.value = [...options.value, ""];
                }}
              >
                Another option
              </Button>
            )}
          </>
        )}
        <p class="quiet">
          {isAxis ? "The right number is" : "A right option, marked with ✓, is"} shown to the class with the result. One
          answer is counted for each browser that has joined.
        </p>
        {!room.isConnected.value && <p role="status">The class cannot be reached now. Connecting …</p>}
        <div class="dialog-actions">
          <Button
            onClick={() => {
              isOpen.value = false;
            }}
          >
            Cancel
          </Button>
          <Button kind="primary" disabled={!isReady} onClick={ask}>
            Ask
          </Button>
        </div>
      </form>
    </dialog>
  );
}
