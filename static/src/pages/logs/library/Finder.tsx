import { useRef } from "preact/hooks";
import { Select } from "../../../ui/Select";
import { allTags, EVERYTHING, logs, ORDERS, PAGE, total, type Wanted, wanted } from "./library";

/** Number of logs from which on they are searched and sorted. */
const MANY = 7;
/** Delay from a key to the search. */
const SETTLE_MS = 200;

export const isFiltered = (): boolean => wanted.value.words !== "" || wanted.value.tags.length > 0;

const choose = (change: Partial<Wanted>): void => {
  wanted.value = { ...wanted.peek(), limit: PAGE, ...change };
};

/** Search, order and tags; nothing while there are few logs. */
export function Finder() {
  const timer = useRef<ReturnType<typeof setTimeout>>(undefined);
  const tags = Object.entries(allTags.value);
  const now = wanted.value;
  const isAsIs = now === EVERYTHING || (!isFiltered() && now.order === "newest");
  if (logs.value === null || (total.value < MANY && tags.length === 0 && isAsIs)) return null;
  return (
    <search class="finder">
      <input
        class="field-text finder-words"
        type="search"
        placeholder="Search name, format, topic, tag"
        aria-label="Search logs"
        defaultValue={now.words}
        onInput={(event) => {
          const words = event.currentTarget.value.trim();
          clearTimeout(timer.current);
          timer.current = setTimeout(() => choose({ words }), SETTLE_MS);
        }}
      />
      <Select
        class="finder-order"
        label="Order"
        value={now.order}
        options={ORDERS}
        onChange={(order) => choose({ order: order as Wanted["order"] })}
      />
      {tags.map(([tag, count]) => {
        const isOn = now.tags.includes(tag);
        return (
          <button
            key={tag}
            type="button"
            class="tag"
            aria-pressed={isOn}
            onClick={() => choose({ tags: isOn ? now.tags.filter((one) => one !== tag) : [...now.tags, tag] })}
          >
            {tag} <span class="number">{count}</span>
          </button>
        );
      })}
      <span class="visually-hidden" role="status">
        {isFiltered() ? `${total.value} logs found` : ""}
      </span>
    </search>
  );
}
