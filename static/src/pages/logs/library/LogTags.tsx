import { useSignal } from "@preact/signals";
import { useLayoutEffect, useRef } from "preact/hooks";
import { Button } from "../../../ui/Button";
import { toast } from "../../../ui/Toast";
import { type LogRecord, putTags } from "./library";

/** The tags of a log, and a field in which they are changed. */
export function LogTags({ log }: { readonly log: LogRecord }) {
  const isEdited = useSignal(false);
  const field = useRef<HTMLInputElement>(null);
  useLayoutEffect(() => {
    if (isEdited.value) field.current?.focus();
  }, [isEdited.value]);
  const save = async (): Promise<void> => {
    const tags = (field.current?.value ?? "").split(",").filter((tag) => tag.trim() !== "");
    const wrong = await putTags(log.id, tags);
    if (wrong) toast(wrong, "error");
    else isEdited.value = false;
  };
  if (isEdited.value) {
    return (
      <form
        class="log-tags"
        onSubmit={(event) => {
          event.preventDefault();
          void save();
        }}
      >
        <input
          ref={field}
          class="field-text tag-field"
          aria-label={`Tags of ${log.name}, with commas between them`}
          placeholder="corridor, night"
          defaultValue={log.tags.join(", ")}
          onKeyDown={(event) => {
            if (event.key === "Escape") isEdited.value = false;
          }}
        />
        <Button kind="quiet" icon="check" label="Save tags" onClick={() => void save()} />
      </form>
    );
  }
  return (
    <div class="log-tags">
      {log.tags.map((tag) => (
        <span key={tag} class="tag">
          {tag}
        </span>
      ))}
      <button
        type="button"
        class="tag add"
        aria-label={log.tags.length === 0 ? `Add a tag to ${log.name}` : `Change the tags of ${log.name}`}
        onClick={() => {
          isEdited.value = true;
        }}
      >
        {log.tags.length === 0 ? "Add a tag" : "Change"}
      </button>
    </div>
  );
}
