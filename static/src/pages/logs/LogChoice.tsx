/** A menu of the visitor's other logs, and of the sensor if a log has several. */

import { useEffect } from "preact/hooks";
import { Select } from "../../ui/Select";
import { type LogRecord, logs, watchAll } from "./library/library";

export interface ChosenLog {
  readonly log: string;
  readonly topic: string | null;
}

interface LogChoiceProps {
  /** The log to exclude. */
  readonly own: string;
  readonly chosen: ChosenLog | null;
  readonly disabled: boolean;
  /** Whether maps are offered too. */
  readonly withMaps?: boolean;
  /** Whether only maps and clouds are offered. */
  readonly onlyTerrains?: boolean;
  readonly onChoose: (chosen: ChosenLog) => void;
}

const SEPARATOR = "\n";

/** Whether it has terrain costs: those of a map exist, and the points of a cloud are assessed. */
const isTerrain = (log: LogRecord): boolean => log.map !== null || log.clouds > 0;

export function LogChoice({ own, chosen, disabled, withMaps = false, onlyTerrains = false, onChoose }: LogChoiceProps) {
  useEffect(watchAll, []);
  const list = (logs.value ?? []).filter(
    (log) =>
      log.state === "ready" &&
      log.id !== own &&
      log.costmaps === 0 &&
      (onlyTerrains ? isTerrain(log) : withMaps || !log.map),
  );
  const choices = list.flatMap((log) => {
    const sensors = log.topics.filter((topic) => topic.beams !== null);
    return sensors.length > 1
      ? sensors.map((topic) => ({ id: log.id, topic: topic.name, label: `${log.name}, ${topic.name}` }))
      : [{ id: log.id, topic: "", label: log.map ? `${log.name} (map)` : log.name }];
  });
  const [some, no] = onlyTerrains
    ? ["Choose a map or cloud …", "No map and no cloud"]
    : ["Choose a log …", "No other log"];
  const none = choices.length > 0 ? some : no;
  return (
    <label class="field">
      <span class="visually-hidden">{onlyTerrains ? "The map or cloud" : "The other log"}</span>
      <Select
        disabled={disabled || choices.length === 0}
        value={chosen ? chosen.log + SEPARATOR + (chosen.topic ?? "") : ""}
        options={[
          { value: "", label: none },
          ...choices.map(({ id, topic, label }) => ({ value: id + SEPARATOR + topic, label })),
        ]}
        onChange={(value) => {
          const [log = "", topic = ""] = value.split(SEPARATOR);
          if (log) onChoose({ log, topic: topic || null });
        }}
      />
    </label>
  );
}
