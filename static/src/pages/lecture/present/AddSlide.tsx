import { useSignal } from "@preact/signals";
import { Choice } from "../../../ui/Choice";
import { LONGEST_TEXT, LONGEST_TITLE, pageAddress, type Slide } from "./deck";

const KINDS = ["text", "lab", "log"] as const;
const ADDRESSES = {
  lab: "Link of the lab: press Share there and paste it here",
  log: "Address of the log’s page, or its shared link",
} as const;

/** The form for a slide of the lecturer's own. */
export function AddSlide({ onAdd }: { readonly onAdd: (slide: Slide) => void }) {
  const kind = useSignal<(typeof KINDS)[number]>("text");
  const problem = useSignal("");
  const add = (event: SubmitEvent): void => {
    event.preventDefault();
    const form = event.currentTarget as HTMLFormElement;
    const fields = new FormData(form);
    const field = (name: string): string => String(fields.get(name) ?? "").trim();
    const notes = field("notes") ? { notes: field("notes") } : {};
    const title = field("title");
    problem.value = "";
    try {
      if (kind.peek() === "text") onAdd({ kind: "text", title, text: field("text"), ...notes });
      else {
        const page = kind.peek() as "lab" | "log";
        onAdd({ kind: page, title, address: pageAddress(page, field("address"), "The new slide"), ...notes });
      }
      form.reset();
    } catch (error) {
      problem.value = (error as Error).message;
    }
  };
  return (
    <details class="deck-add">
      <summary>Add a slide</summary>
      <form onSubmit={add}>
        <Choice
          label="What it shows"
          value={kind.value}
          options={[
            { value: "text", label: "own text" },
            { value: "lab", label: "the lab" },
            { value: "log", label: "a log" },
          ]}
          onChange={(value) => {
            kind.value = value as (typeof KINDS)[number];
          }}
        />
        <label>
          <span>Title</span>
          <input type="text" name="title" required maxLength={LONGEST_TITLE} />
        </label>
        {kind.value === "text" ? (
          <label>
            <span>Text: an empty line begins the next step, a dash an item of a list</span>
            <textarea name="text" required rows={4} maxLength={LONGEST_TEXT} />
          </label>
        ) : (
          <label>
            <span>{ADDRESSES[kind.value]}</span>
            <input type="text" name="address" required />
          </label>
        )}
        <label>
          <span>Notes, for the speaker’s window only</span>
          <textarea name="notes" rows={2} maxLength={LONGEST_TEXT} />
        </label>
        <p class="deck-problem" role="alert">
          {problem.value}
        </p>
        <button type="submit" class="button primary">
          Add at the end
        </button>
      </form>
    </details>
  );
}
