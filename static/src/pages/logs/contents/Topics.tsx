import { shownTime } from "../../../store/shownTime";
import type { Store } from "../../../store/store";
import { Button } from "../../../ui/Button";
import { bytes } from "../../../ui/numbers";
import type { ContentsAnswer, TopicAnswer } from "../../../wire/http";
import type { LogInfo } from "../../../wire/protocol";
import { SENSOR_SEPARATOR } from "../library/describeLog";
import { SensorProgress } from "../sensor/SensorProgress";
import type { SensorState } from "../sensor/useSensor";
import { rateLabel } from "./labels";
import "./contents.css";
import { WhenKnown } from "./useContents";

interface TopicsProps {
  readonly store: Store;
  /** Maps another topic; null for a guest. */
  readonly sensor: SensorState | null;
  /** The log of the session; null until it is known. */
  readonly log: LogInfo | null;
  /** Show the messages of a topic. */
  readonly onMessages: (topic: string) => void;
}

/** Every topic of a recording with its type, count, rate, duration and size. Those of sensors can be mapped. */
export function Topics({ store, sensor, log, onMessages }: TopicsProps) {
  return (
    <WhenKnown>
      {(contents) => (
        <>
          <Table
            store={store}
            contents={contents}
            sensor={sensor}
            mapped={log?.topic.split(SENSOR_SEPARATOR) ?? []}
            onMessages={onMessages}
          />
          {sensor && <SensorProgress sensor={sensor} />}
        </>
      )}
    </WhenKnown>
  );
}

/** Depth images, from which a scan can be cut; drivers name their topics so. */
const isSensor = ({ mapped, cut, name, type }: TopicAnswer): boolean =>
  mapped !== null || (cut && (!type.endsWith("Image") || /depth/i.test(name)));

interface TableProps {
  readonly store: Store;
  readonly contents: ContentsAnswer;
  readonly sensor: SensorState | null;
  /** The topics of the map. */
  readonly mapped: readonly string[];
  readonly onMessages: (topic: string) => void;
}

function Table({ store, contents, sensor, mapped, onMessages }: TableProps) {
  const { topics, notes } = contents;
  if (topics.length === 0) {
    return <p class="quiet">This kind of log contains only scans and poses: it has no topics.</p>;
  }
  const lidars = topics.filter(({ mapped: of, type }) => of !== null && /LaserScan|EchoLaserScan/.test(type));
  const together = lidars.map(({ name }) => name);
  const all = topics.reduce((sum, topic) => sum + topic.bytes, 0);
  return (
    <>
      <table class="topics">
        <caption class="quiet">
          {topics.length} topics, {bytes(all)} of messages. The bar shows when each one was recorded.
        </caption>
        <thead>
          <tr>
            <th scope="col">Topic</th>
            <th scope="col">Messages</th>
            <th scope="col">Rate</th>
            <th scope="col">Size</th>
          </tr>
        </thead>
        <tbody>
          {topics.map((topic) => (
            <Row
              key={`${topic.name} ${topic.type}`}
              store={store}
              topic={topic}
              whole={wholeSpan(topics)}
              isMapped={mapped.includes(topic.name)}
              onMessages={() => onMessages(topic.name)}
              sensor={isSensor(topic) && (mapped.length > 1 || !mapped.includes(topic.name)) ? sensor : null}
            />
          ))}
        </tbody>
      </table>
      {sensor && together.length > 1 && together.some((name) => !mapped.includes(name)) && (
        <Button
          disabled={sensor.reading.value !== null}
          onClick={() => void sensor.use(together.join(SENSOR_SEPARATOR), null)}
        >
          Map {together.length} lidars together
        </Button>
      )}
      {notes.map((note) => (
        <p key={note} class="quiet">
          {note}
        </p>
      ))}
    </>
  );
}

/** Times of the first and of the last message of all topics, s; infinite and reversed if there are no times. */
function wholeSpan(topics: readonly TopicAnswer[]): readonly [first: number, last: number] {
  const times = topics.flatMap(({ first_s, last_s }) => [first_s, last_s]).filter((time) => time !== null);
  return [Math.min(...times), Math.max(...times)];
}

interface RowProps {
  readonly store: Store;
  readonly topic: TopicAnswer;
  readonly whole: readonly [first: number, last: number];
  readonly isMapped: boolean;
  /** Maps the topic alone; null if it cannot be mapped. */
  readonly sensor: SensorState | null;
  readonly onMessages: () => void;
}

function Row({ store, topic, whole: [first, last], isMapped, sensor, onMessages }: RowProps) {
  const { name, type, messages, rate_hz, first_s, last_s } = topic;
  const hasSpan = first_s !== null && last_s !== null && last > first;
  return (
    <tr>
      <th scope="row">
        <button type="button" class="topic-name" aria-label={`Messages on ${name}`} onClick={onMessages}>
          {name}
        </button>
        <span class="quiet">
          {type}
          {isMapped && <strong class="topic-mapped"> · mapped</strong>}
        </span>
        {hasSpan && (
          <span
            class="topic-span"
            title={`${shownTime(store, first_s)} to ${shownTime(store, last_s)}`}
            style={{ "--from": (first_s - first) / (last - first), "--to": (last_s - first) / (last - first) }}
          >
            <span class="visually-hidden">
              from {shownTime(store, first_s)} to {shownTime(store, last_s)}
            </span>
          </span>
        )}
        {sensor && (
          <button
            type="button"
            class="topic-map"
            aria-label={`Map ${name}`}
            disabled={sensor.reading.value !== null}
            onClick={() => void sensor.use(name, null)}
          >
            {isMapped ? "Map this one by itself" : "Map this one"}
          </button>
        )}
      </th>
      <td>{messages.toLocaleString("en")}</td>
      <td>{rateLabel(rate_hz)}</td>
      <td>{bytes(topic.bytes)}</td>
    </tr>
  );
}
