/** The tree of frames as a picture, each transform at the selected time, and the frames that only messages name. */

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Store } from "../../../store/store";
import { showAnswer } from "../../../ui/browser/attempts";
import { Failure } from "../../../ui/Failure";
import { written } from "../../../ui/numbers";
import { SelectField } from "../../../ui/Select";
import { addressOf, answerAt, ask } from "../../../wire/ask";
import type { FrameEdgeAnswer, FramesAnswer, SeriesAnswer, TopicFieldsAnswer } from "../../../wire/http";
import { useFieldNames } from "../fields/useFields";
import { poseInFrame } from "./frameLookup";
import { Plot } from "./LazyPlot";
import { ageLabel, rateLabel } from "./labels";
import { useAtMoment } from "./useAtMoment";
import { WhenKnown } from "./useContents";

interface PlacedFrame {
  readonly name: string;
  readonly depth: number;
  /** The line, from 0. */
  readonly line: number;
  /** The edge to its parent, null for a root. */
  readonly edge: FrameEdgeAnswer | null;
  /** The line of its parent. */
  readonly parentLine: number | null;
}

/**
 * Place every frame: roots in the order of their names, with that of the fixed frame first. A frame of a loop, which is
 * not reachable from a root, starts another tree.
 */
export function placedFrames(
  names: readonly string[],
  edges: readonly FrameEdgeAnswer[],
  fixed: string,
): PlacedFrame[] {
  const used = edges.filter((edge) => edge.used);
  const edgeOf = new Map(used.map((edge) => [edge.child, edge]));
  const children = new Map<string, FrameEdgeAnswer[]>();
  for (const edge of used) children.set(edge.parent, [...(children.get(edge.parent) ?? []), edge]);
  const placed: PlacedFrame[] = [];
  const seen = new Set<string>();
  const place = (name: string, depth: number, edge: FrameEdgeAnswer | null, parentLine: number | null): void => {
    if (seen.has(name)) return;
    seen.add(name);
    const line = placed.length;
    placed.push({ name, depth, line, edge, parentLine });
    for (const edge of children.get(name) ?? []) place(edge.child, depth + 1, edge, line);
  };
  const rootOf = (name: string): string => {
    const passed = new Set<string>();
    let at = name;
    while (!passed.has(at)) {
      passed.add(at);
      at = edgeOf.get(at)?.parent ?? at;
    }
    return at;
  };
  place(rootOf(fixed), 0, null, null);
  for (const name of names) if (!edgeOf.has(name)) place(name, 0, null, null);
  for (const name of names) place(name, 0, null, null);
  return placed;
}

interface NamedFrame {
  readonly name: string;
  readonly topics: readonly string[];
  /** What the transforms lack, as the end of a sentence. */
  readonly lacks: string;
}

/**
 * The frames that messages name and that no transform connects to the fixed frame; `tree` is null without transforms.
 */
export function unjoinedFrames(
  topics: readonly Pick<TopicFieldsAnswer, "topic" | "frames">[],
  tree: Pick<FramesAnswer, "frames" | "elsewhere" | "edges" | "fixed"> | null,
): readonly NamedFrame[] {
  const topicsOf = new Map<string, string[]>();
  for (const { topic, frames } of topics) {
    for (const name of frames) topicsOf.set(name, [...(topicsOf.get(name) ?? []), topic]);
  }
  const placed = tree ? placedFrames(tree.frames, tree.edges, tree.fixed) : [];
  const next = placed.findIndex(({ depth }, line) => line > 0 && depth === 0);
  const joined = new Set(placed.slice(0, next < 0 ? undefined : next).map(({ name }) => name));
  const lackOf = (name: string): string => {
    if (!tree) return "the log has no transforms";
    if (tree.frames.includes(name)) return `no transform joins it with ${tree.fixed}`;
    return tree.elsewhere.includes(name) ? "it is in other transforms of the log" : "no transform names it";
  };
  return [...topicsOf]
    .filter(([name]) => !joined.has(name))
    .map(([name, topics]) => ({ name, topics, lacks: lackOf(name) }))
    .sort((a, b) => a.name.localeCompare(b.name));
}

/** Whether a transform is older than twice its usual interval and more than 0.2 s. */
export function isLate({ static: isStatic, age_s: age, rate_hz: rate }: FrameEdgeAnswer): boolean {
  if (isStatic) return false;
  return age === null || age > Math.max(0.2, rate === null ? 1 : 2 / rate);
}

const FRAMES = "GET /api/sessions/{session_id}/contents/frames";

interface FrameTreeProps {
  readonly store: Store;
  readonly session: string;
}

export function FrameTree({ store, session }: FrameTreeProps) {
  return (
    <WhenKnown>
      {({ frames }) =>
        frames > 0 ? (
          <Tree store={store} session={session} />
        ) : (
          <div class="frames">
            <p class="quiet">The log has no transforms (tf): there is no tree of frames.</p>
            <Unjoined session={session} tree={null} />
          </div>
        )
      }
    </WhenKnown>
  );
}

function Tree({ store, session }: FrameTreeProps) {
  const chosen = useSignal<string | null>(null);
  const topic = useSignal<string | null>(null);
  const query = {
    ...(chosen.value === null ? {} : { fixed: chosen.value }),
    ...(topic.value === null ? {} : { tf: topic.value }),
  };
  const answer = useAtMoment<FramesAnswer>(
    store,
    (at) => addressOf(FRAMES, { session_id: session }, { at, ...query }),
    (address, ending) => answerAt(FRAMES, address, ending),
  );
  if (answer.kind === "failed") return <p role="alert">{answer.why}</p>;
  if (answer.kind === "none") return <p class="quiet">…</p>;
  const frames = answer.value;
  return (
    <div class="frames">
      {frames.trees.length > 1 && (
        <SelectField
          title="Transforms on"
          value={frames.tf}
          options={frames.trees}
          onChange={(tf) => {
            chosen.value = null;
            topic.value = tf;
          }}
        />
      )}
      <SelectField
        title="Fixed frame"
        value={frames.fixed}
        options={frames.frames}
        onChange={(frame) => {
          chosen.value = frame;
        }}
      />
      {frames.faults.length > 0 ? (
        <ul class="frames-faults" aria-label="What is missing">
          {frames.faults.map((fault) => (
            <li key={fault}>{fault}</li>
          ))}
        </ul>
      ) : (
        <p class="quiet">
          Transforms lead from the sensor’s frame, {frames.sensor || "without a name"}, to {frames.fixed}.
        </p>
      )}
      <Picture frames={frames} />
      <p class="quiet">
        Beside each frame: how often its transform comes and how old it is at this moment of the log. Dashed: static,
        valid at all times. Orange: older than twice its usual interval, or not received yet.
      </p>
      <BetweenFrames frames={frames} />
      <Transforms edges={frames.edges} />
      <Age store={store} session={session} edges={frames.edges} />
      {/* Last: it appears late, and no control is to move for it. */}
      <Unjoined session={session} tree={frames} />
    </div>
  );
}

const MOST_TOPICS = 4;

/** The frames that only messages name. */
function Unjoined({ session, tree }: { readonly session: string; readonly tree: FramesAnswer | null }) {
  const topics = useFieldNames(session);
  if (topics.kind === "failed") return <p role="alert">{topics.why}</p>;
  if (topics.kind === "reading") return <p class="quiet">Looking up which frames messages name …</p>;
  const unjoined = unjoinedFrames(topics.value, tree);
  if (unjoined.length === 0) return null;
  return (
    <section aria-label="Frames without a transform">
      <ul class="frames-faults">
        {unjoined.map(({ name, topics, lacks }) => (
          <li key={name}>
            <strong>{name}</strong>, named on {topics.slice(0, MOST_TOPICS).join(", ")}
            {topics.length > MOST_TOPICS && ` and ${topics.length - MOST_TOPICS} more`}: {lacks}.
          </li>
        ))}
      </ul>
      <p class="quiet">By the first message of each topic.</p>
    </section>
  );
}

const DEGREES = 180 / Math.PI;

/** x, y, z in metres, or roll, pitch and yaw in degrees. */
const three = (values: readonly number[] | null, digits: number, unit: string): string =>
  values === null ? "not yet" : `${values.map((value) => written(value, digits)).join(", ")} ${unit}`;

/** The pose of one frame in another at the selected time, initially of the sensor in the fixed frame. */
function BetweenFrames({ frames }: { readonly frames: FramesAnswer }) {
  const chosen = useSignal<{ readonly child?: string; readonly parent?: string }>({});
  const known = (name: string | undefined, other: string): string =>
    name !== undefined && frames.frames.includes(name) ? name : other;
  const parent = known(chosen.value.parent, frames.fixed);
  const child = known(chosen.value.child, known(frames.sensor, frames.frames[0] ?? parent));
  const pose = poseInFrame(frames.edges, child, parent);
  return (
    <section class="frames-between" aria-label="Transform between two frames">
      <SelectField
        title="Frame"
        value={child}
        options={frames.frames}
        onChange={(name) => {
          chosen.value = { ...chosen.peek(), child: name };
        }}
      />
      <SelectField
        title="In the frame"
        value={parent}
        options={frames.frames}
        onChange={(name) => {
          chosen.value = { ...chosen.peek(), parent: name };
        }}
      />
      <p class="number" role="status">
        {"why" in pose ? pose.why : `${three(pose.offset, 3, "m")}; ${three(degreesOf(pose.angles), 1, "°")}`}
      </p>
    </section>
  );
}

const degreesOf = (angles: readonly number[]): readonly number[] => angles.map((angle) => DEGREES * angle);

/** The position of each frame in its parent at the selected time, and its publisher. */
function Transforms({ edges }: { readonly edges: readonly FrameEdgeAnswer[] }) {
  return (
    <table class="topics">
      <caption class="quiet">
        Each transform at this moment: x, y, z, and roll, pitch, yaw.
        {edges.every(({ publishers }) => publishers.length === 0) &&
          " The topic stands for who published it: only ROS 1 bags, and MCAP files made of them, name the node."}
      </caption>
      <tbody>
        {edges.map((edge) => (
          <tr key={nameOf(edge)}>
            <th scope="row">
              {edge.child}
              <span class="quiet">
                {" "}
                in {edge.parent}, by {edge.publishers.join(", ") || edge.topic}
              </span>
            </th>
            <td>
              {three(edge.offset, 3, "m")}
              {edge.angles && (
                <>
                  <br />
                  {three(degreesOf(edge.angles), 1, "°")}
                </>
              )}
            </td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

/** An edge in a word. A frame can have several parents, and a parent several topics. */
const nameOf = ({ topic, parent, child }: FrameEdgeAnswer): string => `${child} in ${parent} on ${topic}`;

/** The age of a selected transform over the time of the log. */
function Age({ store, session, edges }: FrameTreeProps & { readonly edges: readonly FrameEdgeAnswer[] }) {
  const moving = edges.filter((edge) => !edge.static);
  const name = useSignal("");
  const answer = useSignal<SeriesAnswer | null>(null);
  const failure = useSignal<string | null>(null);
  const chosen = name.value;
  useEffect(() => {
    answer.value = null;
    const edge = moving.find((edge) => nameOf(edge) === chosen);
    if (!edge) return;
    const query = { tf: edge.topic, parent: edge.parent, child: edge.child };
    const what = "GET /api/sessions/{session_id}/contents/frame_age";
    return showAnswer(
      (ending) => ask(what, { session_id: session }, { query, ending }),
      failure,
      (series) => {
        answer.value = series;
      },
    );
  }, [session, chosen]);
  if (moving.length === 0) return null;
  return (
    <>
      <SelectField
        title="Age over time of"
        value={chosen}
        options={[{ value: "", label: "–" }, ...moving.map(nameOf).map((value) => ({ value, label: value }))]}
        onChange={(value) => {
          name.value = value;
        }}
      />
      <Failure why={failure.value} />
      {answer.value && <Plot key={chosen} store={store} series={answer.value} plot="age" />}
    </>
  );
}

const LINE = 34;
const INDENT = 22;
const BOX = 24;
const CHARACTER = 7.6; // width of a character in a box, px, rounded up

function Picture({ frames }: { readonly frames: FramesAnswer }) {
  const placed = placedFrames(frames.frames, frames.edges, frames.fixed);
  const boxOf = ({ name }: PlacedFrame): number => CHARACTER * Math.min(name.length, 40) + 20;
  const width = Math.max(...placed.map((frame) => INDENT * frame.depth + boxOf(frame) + 150));
  return (
    // biome-ignore lint/a11y/noNoninteractiveTabindex: it scrolls sideways, which the keyboard can only do with the focus
    <section class="frames-picture" tabIndex={0} aria-label="The frames as a tree">
      <svg width={width} height={LINE * placed.length} role="img" aria-label={inWords(frames)}>
        {placed.map((frame) => {
          const x = INDENT * frame.depth;
          const y = LINE * frame.line + LINE / 2;
          const isFixed = frame.name === frames.fixed;
          const isSensor = frame.name === frames.sensor;
          const late = frame.edge !== null && isLate(frame.edge);
          return (
            <g key={frame.name} class={["frame", isFixed && "fixed", isSensor && "sensor"].filter(Boolean).join(" ")}>
              {frame.edge && frame.parentLine !== null && (
                <path
                  class={["edge", frame.edge.static && "static", late && "late"].filter(Boolean).join(" ")}
                  d={`M${x - INDENT / 2} ${LINE * frame.parentLine + LINE / 2 + BOX / 2}V${y}H${x}`}
                />
              )}
              <rect x={x + 0.5} y={y - BOX / 2} width={boxOf(frame)} height={BOX} rx={5} />
              <text x={x + 8} y={y + 4.5}>
                {frame.name.slice(0, 40)}
              </text>
              {frame.edge && (
                <text class={late ? "edge-label late" : "edge-label"} x={x + boxOf(frame) + 8} y={y + 4.5}>
                  {edgeLabel(frame.edge)}
                </text>
              )}
            </g>
          );
        })}
      </svg>
    </section>
  );
}

function edgeLabel(edge: FrameEdgeAnswer): string {
  if (edge.static) return "static";
  const age = edge.age_s === null ? "not yet" : `${ageLabel(edge.age_s)} old`;
  return edge.rate_hz === null ? age : `${rateLabel(edge.rate_hz)}, ${age}`;
}

/** The tree for screen readers. */
function inWords({ edges, fixed }: FramesAnswer): string {
  const sentences = edges
    .filter(({ used }) => used)
    .map((edge) => `${edge.child} in ${edge.parent}, ${edgeLabel(edge)}`);
  return `Fixed frame ${fixed}. ${sentences.join("; ")}.`;
}
