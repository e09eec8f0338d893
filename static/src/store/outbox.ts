import type { Command, Value, Values } from "../wire/protocol";

/**
 * Run a task after the next frame is painted: the user's own change is displayed first, and a server on the same machine
 * takes no time from that frame.
 */
const afterFrame = (task: () => void): void => void requestAnimationFrame(() => void setTimeout(task));

const valuesOf = (command: Command): Values => ("values" in command && command.values) || {};

function joined(before: Command, command: Command): Command {
  const values = { ...valuesOf(before), ...valuesOf(command) };
  return { ...before, ...command, ...(Object.keys(values).length > 0 && { values }) } as Command;
}

/** Waiting commands: of each kind only the newest is sent, once per animation frame. */
export class Outbox {
  readonly #waiting = new Map<string, Command>();
  readonly #joined = new Set<string>();
  readonly #send: (command: Command) => void;
  readonly #schedule: (task: () => void) => void;

  constructor(send: (command: Command) => void, schedule: (task: () => void) => void = afterFrame) {
    this.#send = send;
    this.#schedule = schedule;
  }

  /** Join the commands of a type: of a change in several fields, such as that of the costmap, the newest of each is sent. */
  join(type: string): void {
    this.#joined.add(type);
  }

  put(command: Command): void {
    const isFirst = this.#waiting.size === 0;
    // Of requests about two layers the newest for each is sent.
    const about = "layer" in command ? ` ${command.layer}` : "";
    const key = command.type + about;
    const before = this.#waiting.get(key);
    this.#waiting.set(key, before && this.#joined.has(command.type) ? joined(before, command) : command);
    if (isFirst) this.#schedule(() => this.flush());
  }

  /** Add one value to the waiting `parameters` or `sensor` command. */
  putValue(type: "parameters" | "sensor", name: string, value: Value): void {
    const waiting = this.#waiting.get(type);
    const before = waiting ? valuesOf(waiting) : {};
    this.put({ type, values: { ...before, [name]: value } });
  }

  flush(): void {
    const commands = [...this.#waiting.values()];
    this.#waiting.clear();
    for (const command of commands) this.#send(command);
  }
}
