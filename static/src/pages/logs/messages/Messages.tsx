/** The newest message of a topic at the log's present time, as a tree of its fields. */

import { type Signal, useSignal } from "@preact/signals";
import { shownTime } from "../../../store/shownTime";
import type { Store } from "../../../store/store";
import { Button } from "../../../ui/Button";
import { bytes, signed } from "../../../ui/numbers";
import { SelectField } from "../../../ui/Select";
import { toast } from "../../../ui/Toast";
import { addressOf, answerAt } from "../../../wire/ask";
import type { MessageAnswer } from "../../../wire/http";
import { useAtMoment } from "../contents/useAtMoment";
import { WhenKnown } from "../contents/useContents";
import "./messages.css";

type Tree = string | number | boolean | null | readonly Tree[] | { readonly [name: string]: Tree };

/** Whether a value has children. */
const isBranch = (value: Tree): value is readonly Tree[] | { readonly [name: string]: Tree } =>
  typeof value === "object" && value !== null;

/** The children of a value, with the names of fields or the indices of elements. */
const partsOf = (value: readonly Tree[] | { readonly [name: string]: Tree }): readonly [string, Tree][] =>
  Array.isArray(value)
    ? value.map((child: Tree, n): [string, Tree] => [String(n), child])
    : Object.entries(value as { readonly [name: string]: Tree });

/** Text without quotes: numbers that JSON does not have. */
const PLAIN = /^(\.nan|-?\.inf|-?\d{16,20})$/;

/** A value without children in YAML. */
function scalar(value: Tree): string {
  if (typeof value !== "string") return Array.isArray(value) ? "[]" : isBranch(value) ? "{}" : String(value);
  if (PLAIN.test(value)) return value;
  return JSON.stringify(value); // text in JSON's quotes is valid YAML
}

/** A name as a key of YAML; a field's name in JSON may be any text. */
const key = (name: string): string => (/^[A-Za-z_]\w*$/.test(name) ? name : JSON.stringify(name));

/** The lines of a message; an element of a sequence starts with a dash. */
export function yamlOf(value: Tree, indent = ""): string {
  if (!isBranch(value) || partsOf(value).length === 0) return `${indent}${scalar(value)}\n`;
  const isList = Array.isArray(value);
  return partsOf(value)
    .map(([name, part]) => {
      const isNested = isBranch(part) && partsOf(part).length > 0;
      if (!isList)
        return isNested
          ? `${indent}${key(name)}:\n${yamlOf(part, `${indent}  `)}`
          : `${indent}${key(name)}: ${scalar(part)}\n`;
      return isNested
        ? `${indent}- ${yamlOf(part, `${indent}  `).slice(indent.length + 2)}`
        : `${indent}- ${scalar(part)}\n`;
    })
    .join("");
}

const MESSAGE = "GET /api/sessions/{session_id}/contents/message";

interface MessagesProps {
  readonly store: Store;
  readonly session: string;
  /** The topic shown; "" for the first. */
  readonly topic: Signal<string>;
  /** Plot a numeric field of a topic by its path. */
  readonly onPlot: (topic: string, field: string) => void;
}

export function Messages({ store, session, topic, onPlot }: MessagesProps) {
  return (
    <WhenKnown>
      {({ topics }) => {
        const names = topics.map(({ name }) => name);
        const chosen = names.includes(topic.value) ? topic.value : (names[0] ?? "");
        if (chosen === "") return <p class="quiet">This kind of log has no ROS messages.</p>;
        return (
          <div class="messages">
            <SelectField
              title="Topic"
              value={chosen}
              options={topics.map(({ name, type }) => ({
                value: name,
                label: `${name} (${type.replace(/^.*\//, "")})`,
              }))}
              onChange={(name) => {
                topic.value = name;
              }}
            />
            <OfTopic key={chosen} store={store} session={session} topic={chosen} onPlot={onPlot} />
          </div>
        );
      }}
    </WhenKnown>
  );
}

function OfTopic({ store, session, topic, onPlot }: Omit<MessagesProps, "topic"> & { readonly topic: string }) {
  const answer = useAtMoment<MessageAnswer>(
    store,
    (at) => addressOf(MESSAGE, { session_id: session }, { topic, at }),
    (address, ending) => answerAt(MESSAGE, address, ending),
  );
  const open = useSignal<ReadonlySet<string>>(new Set(["header", "header.stamp"]));
  if (answer.kind === "failed") return <p role="alert">{answer.why}</p>;
  if (answer.kind === "none") {
    return (
      <div class="progress waiting wide" role="status" aria-label="The message is being read">
        <span />
      </div>
    );
  }
  const message = answer.value;
  const fields = message.fields as { readonly [name: string]: Tree };
  const copy = async (text: string, what: string): Promise<void> => {
    try {
      await navigator.clipboard.writeText(text);
      toast(`Copied as ${what}.`);
    } catch {
      toast("The browser does not allow copying here.", "error");
    }
  };
  const at = store.frame.value?.stamp ?? 0;
  return (
    <>
      <p class="quiet">
        {message.type}, {bytes(message.bytes)}, recorded at {shownTime(store, message.seconds)} (
        {signed(message.seconds - at, 3)} s)
      </p>
      <div class="actions">
        <Button kind="quiet" onClick={() => void copy(yamlOf(fields), "YAML")}>
          Copy as YAML
        </Button>
        <Button kind="quiet" onClick={() => void copy(JSON.stringify(fields, null, 2), "JSON")}>
          Copy as JSON
        </Button>
      </div>
      <Branch value={fields} path="" open={open} onPlot={(field) => onPlot(topic, field)} />
    </>
  );
}

interface BranchProps {
  readonly value: readonly Tree[] | { readonly [name: string]: Tree };
  readonly path: string;
  /** The paths of the unfolded branches. */
  readonly open: Signal<ReadonlySet<string>>;
  /** Plot a numeric field by its path. */
  readonly onPlot: (path: string) => void;
}

/**
 * Fields and elements. Those with children can be unfolded, which is kept as the time changes. A numeric field can be
 * plotted.
 */
function Branch({ value, path, open, onPlot }: BranchProps) {
  return (
    <ul class="message-tree">
      {partsOf(value).map(([name, part]) => {
        const own = Array.isArray(value) ? `${path}[${name}]` : [path, name].filter(Boolean).join(".");
        if (!isBranch(part) || partsOf(part).length === 0) {
          return (
            <li key={name}>
              <span class="message-name">{name}</span>{" "}
              {typeof part === "number" ? (
                <button
                  type="button"
                  class="message-value"
                  title={`Plot ${own} over time`}
                  aria-label={`${scalar(part)}: plot ${own}`}
                  onClick={() => onPlot(own)}
                >
                  {scalar(part)}
                </button>
              ) : (
                <span class="message-value">{scalar(part)}</span>
              )}
            </li>
          );
        }
        const count = partsOf(part).length;
        const isOpen = open.value.has(own);
        return (
          <li key={name}>
            <details
              open={isOpen}
              onToggle={(event) => {
                const next = new Set(open.peek());
                if (event.currentTarget.open) next.add(own);
                else next.delete(own);
                if (next.size !== open.peek().size) open.value = next;
              }}
            >
              <summary>
                <span class="message-name">{name}</span>{" "}
                <span class="quiet">{Array.isArray(part) ? `[${count}]` : ""}</span>
              </summary>
              {isOpen && <Branch value={part} path={own} open={open} onPlot={onPlot} />}
            </details>
          </li>
        );
      })}
    </ul>
  );
}
