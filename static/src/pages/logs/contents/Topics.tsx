import { bytes, clock } from "../../../ui/numbers";
import { type Contents, rateLabel, type TopicContents } from "./contents";
import "./contents.css";
import { WhenKnown } from "./useContents";

/** Every topic of a recording with its type, count, rate, span and size. */
export function Topics({ session }: { readonly session: string }) {
  return <WhenKnown session={session}>{(contents) => <Table contents={contents} />}</WhenKnown>;
}

function Table({ contents }: { readonly contents: Contents }) {
  const { topics, notes } = contents;
  if (topics.length === 0) {
    return <p class="quiet">A log of this kind holds nothing but its scans and poses: there is no list of topics.</p>;
  }
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
            <Row key={`${topic.name} ${topic.type}`} topic={topic} whole={wholeSpan(topics)} />
          ))}
        </tbody>
      </table>
      {notes.map((note) => (
        <p key={note} class="quiet">
          {note}
        </p>
      ))}
    </>
  );
}

const wholeSpan = (topics: readonly TopicContents[]): number =>
  topics.reduce((last, topic) => Math.max(last, topic.last_s ?? 0), 0);

function Row({ topic, whole }: { readonly topic: TopicContents; readonly whole: number }) {
  const { name, type, messages, rate_hz, first_s, last_s, mapped } = topic;
  const hasSpan = first_s !== null && last_s !== null;
  return (
    <tr>
      <th scope="row">
        <span class="topic-name">{name}</span>
        <span class="quiet">
          {type}
          {mapped && <strong class="topic-mapped"> · mapped</strong>}
        </span>
        {hasSpan && whole > 0 && (
          <span
            class="topic-span"
            title={`${clock(first_s)} to ${clock(last_s)} of the recording`}
            style={{ "--from": first_s / whole, "--to": last_s / whole }}
          >
            <span class="visually-hidden">
              from {clock(first_s)} to {clock(last_s)}
            </span>
          </span>
        )}
      </th>
      <td>{messages.toLocaleString("en")}</td>
      <td>{rateLabel(rate_hz)}</td>
      <td>{bytes(topic.bytes)}</td>
    </tr>
  );
}
