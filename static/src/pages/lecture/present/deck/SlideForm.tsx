import { useSignal } from "@preact/signals";
import { useEffect, useId } from "preact/hooks";
import { Choice } from "../../../../ui/Choice";
import { ask } from "../../../../wire/ask";
import type { LogAnswer } from "../../../../wire/http";
import { LONGEST_TEXT, LONGEST_TITLE, pageAddress, type Slide } from "./deck";

const ADDRESSES = {
  lab: "Link of the lab: press Share there and paste it here",
  log: "A log from the list, the address of its page, or its shared link",
} as const;

/** The newest logs of this visitor; none if the server does not answer, when an address can still be entered. */
const namedLogs = (): Promise<readonly LogAnswer[]> =>
  ask("GET /api/logs", {}).then(
    ({ logs }) => logs,
    () => [],
  );

/** A slide added by the lecturer. */
export type OwnSlide = Exclude<Slide, { readonly section: string }>;

interface SlideFormProps {
  /** Initial content of the form; null for a new slide. */
  readonly slide?: OwnSlide;
  readonly button: string;
  readonly onSave: (slide: OwnSlide) => void;
}

/** The form for a slide added by the lecturer. */
export function SlideForm({ slide, button, onSave }: SlideFormProps) {
  const kind = useSignal<OwnSlide["kind"]>(slide?.kind ?? "text");
  const problem = useSignal("");
  const logs = useSignal<readonly LogAnswer[]>([]);
  const addresses = useId();
  useEffect(() => {
    if (kind.value === "log" && logs.peek().length === 0) void namedLogs().then((named) => (logs.value = named));
  }, [kind.value, logs]);
  const save = (event: SubmitEvent): void => {
    event.preventDefault();
    const form = event.currentTarget as HTMLFormElement;
    const fields = new FormData(form);
    const field = (name: string): string => String(fields.get(name) ?? "").trim();
    const notes = field("notes") ? { notes: field("notes") } : {};
    const title = field("title");
    problem.value = "";
    try {
      const kept = { title, ...notes, ...(slide?.hidden ? { hidden: true } : {}) };
      const now = kind.peek();
      if (now === "title") onSave({ kind: now, ...kept });
      else if (now === "text") onSave({ kind: now, text: field("text"), ...kept });
      else onSave({ kind: now, address: pageAddress(now, field("address"), "The slide"), ...kept });
      form.reset();
    } catch (error) {
      problem.value = (error as Error).message;
    }
  };
  const page = slide && "address" in slide ? slide.address : "";
  return (
    <form class="deck-form" onSubmit={save}>
      <Choice
        label="What it shows"
        value={kind.value}
        options={[
          { value: "title", label: "title and map" },
          { value: "text", label: "own text" },
          { value: "lab", label: "the lab" },
          { value: "log", label: "a log" },
        ]}
        onChange={(value) => {
          kind.value = value as OwnSlide["kind"];
        }}
      />
      <label>
        <span>Title</span>
        <input
          class="field-text"
          type="text"
          name="title"
          required
          maxLength={LONGEST_TITLE}
          defaultValue={slide?.title ?? ""}
        />
      </label>
      {kind.value === "text" && (
        <label>
          <span>Text: an empty line begins the next step, a dash an item of a list; $p_t = e^x$ is a formula</span>
          <textarea
            class="field-text"
            name="text"
            required
            rows={4}
            maxLength={LONGEST_TEXT}
            defaultValue={slide?.kind === "text" ? slide.text : ""}
          />
        </label>
      )}
      {(kind.value === "lab" || kind.value === "log") && (
        <label key={kind.value}>
          <span>{ADDRESSES[kind.value]}</span>
          <input
            class="field-text"
            type="text"
            name="address"
            required
            defaultValue={slide?.kind === kind.value ? page : ""}
            {...(kind.value === "log" ? { list: addresses } : {})}
          />
          {kind.value === "log" && (
            <datalist id={addresses}>
              {logs.value.map(({ id, name }) => (
                <option key={id} value={`/logs.html?log=${encodeURIComponent(id)}`}>
                  {name}
                </option>
              ))}
            </datalist>
          )}
        </label>
      )}
      <label>
        <span>Notes, for the speaker’s window only</span>
        <textarea class="field-text" name="notes" rows={2} maxLength={LONGEST_TEXT} defaultValue={slide?.notes ?? ""} />
      </label>
      <p class="deck-problem" role="alert">
        {problem.value}
      </p>
      <button type="submit" class="button primary">
        {button}
      </button>
    </form>
  );
}
