import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Classroom } from "../../store/classroom";
import { Button } from "../../ui/Button";
import { Choice } from "../../ui/Choice";

const MOST_OPTIONS = 8;

/** A form for a question that is made on the spot: options to choose from, or a number to guess. */
export function PollForm({ room, isOpen }: { readonly room: Classroom; readonly isOpen: Signal<boolean> }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const kind = useSignal("options");
  const text = useSignal("");
  const options = useSignal<readonly string[]>(["Yes", "No"]);
  const low = useSignal("0");
  const high = useSignal("100");
  const unit = useSignal("");
  const open = isOpen.value;
  useEffect(() => {
    if (open && !dialog.current?.open) dialog.current?.showModal();
    else if (!open) dialog.current?.close();
  }, [open]);
  const given = options.value.map((one) => one.trim()).filter(Boolean);
  const isAxis = kind.value === "number";
  const isReady =
    room.isConnected.value &&
    text.value.trim() !== "" &&
    (isAxis ? low.value !== "" && high.value !== "" && Number(low.value) < Number(high.value) : given.length >= 2);
  const ask = (): void => {
    if (!isReady) return;
    const axis = { low: Number(low.value), high: Number(high.value), unit: unit.value.trim() };
    room.send({ type: "ask", text: text.value, ...(isAxis ? { axis } : { options: given }) });
    isOpen.value = false;
    text.value = "";
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
          value={kind.value}
          onChange={(value) => {
            kind.value = value;
          }}
        />
        {isAxis ? (
          <div class="class-axis-fields">
            {(
              [
                ["From", low],
                ["To", high],
                ["Unit", unit],
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
              <label class="field" key={i}>
                <span class="field-label">Option {String.fromCharCode(65 + i)}</span>
                <input
                  class="field-text"
                  maxLength={300}
                  value={option}
                  onInput={(event) => change(i, event.currentTarget.value)}
                />
              </label>
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
