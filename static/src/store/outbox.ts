import type { Command, Value, Values } from "../wire/protocol";

/**
 * Run a task after the next frame is painted: the user's own change is displayed first, and a server on the same machine
 * takes no time from that frame.
 */
const afterFrame = (task: () => void): void => void requestAnimationFrame(() => void setTimeout(task));

/** Of a change that has several parts, such as that of the costmap, the newest of each part is sent. */
function joined(before: Command | undefined, command: Command): Command {
  for (const type of ["costmap", "map3d", "terrain", "volume_look", "surface"] as const)
    if (command.type === type && before?.type === type)
      return { ...before, ...command, values: { ...before.values, ...command.values } } as Command;
  return command;
}

/** Waiting commands: of each kind only the newest is sent, once per animation frame. */
export class Outbox {
  readonly #waiting = new Map<string, Command>();
  readonly #send: (command: Command) => void;
  readonly #schedule: (task: () => void) => void;

  constructor(send: (command: Command) => void, schedule: (task: () => void) => void = afterFrame) {
    this.#send = send;
    this.#schedule = schedule;
  }

  put(command: Command): void {
    const isFirst = this.#waiting.size === 0;
    // Of requests about two layers the newest for each is sent.
    const about = "layer" in command ? ` ${command.layer}` : "";
    const key = command.type + about;
    const before = this.#waiting.get(key);
    this.#waiting.set(key, joined(before, command));
    if (isFirst) this.#schedule(() => this.flush());
  }

  /** Add one value to the waiting `parameters` or `sensor` command. */
  putValue(type: "parameters" | "sensor", name: string, value: Value): void {
    const waiting = this.#waiting.get(type);
    const before: Values = (waiting && "values" in waiting && waiting.values) || {};
    this.put({ type, values: { ...before, [name]: value } });
  }

  flush(): void {
    const commands = [...this.#waiting.values()];
    this.#waiting.clear();
    for (const command of commands) this.#send(command);
  }
}
