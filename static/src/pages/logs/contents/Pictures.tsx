/** Images and clouds at the log's present time. */

import { type Signal, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { shownTime } from "../../../store/shownTime";
import type { Store } from "../../../store/store";
import { selectionOf } from "../../../tools/scene/selection";
import { signed } from "../../../ui/numbers";
import { SelectField } from "../../../ui/Select";
import { addressOf, ask, fetched } from "../../../wire/ask";
import type { CameraAnswer } from "../../../wire/http";
import { useAtMoment } from "./useAtMoment";
import { WhenKnown } from "./useContents";

interface PicturesProps {
  readonly store: Store;
  readonly session: string;
  /** The topic shown; "" for the first. */
  readonly pictured: Signal<string>;
}

export function Pictures({ store, session, pictured }: PicturesProps) {
  return (
    <WhenKnown>
      {({ pictures }) =>
        pictures.length > 0 ? (
          <OfTopic store={store} session={session} pictured={pictured} topics={pictures} />
        ) : (
          <p class="quiet">The log has no images and no point clouds.</p>
        )
      }
    </WhenKnown>
  );
}

interface Shown {
  readonly topic: string;
  readonly address: string;
  readonly seconds: number;
  readonly isCloud: boolean;
}

/** Fetch a picture. Throws an error with the server's message if it is refused. */
async function fetchPicture(address: string, signal: AbortSignal): Promise<Shown> {
  const answer = await fetched(address, { signal });
  const seconds = Number(answer.headers.get("X-Picture-Seconds"));
  const picture = await answer.blob();
  const topic = new URL(address, location.href).searchParams.get("topic") ?? "";
  return { topic, address: URL.createObjectURL(picture), seconds, isCloud: picture.type === "image/png" };
}

function OfTopic({ store, session, pictured, topics }: PicturesProps & { readonly topics: readonly string[] }) {
  const topic = topics.includes(pictured.value) ? pictured.value : (topics[0] ?? "");
  const answer = useAtMoment<Shown>(
    store,
    (at) => addressOf("GET /api/sessions/{session_id}/contents/picture", { session_id: session }, { topic, at }),
    fetchPicture,
  );
  const shown = answer.kind === "ready" ? answer.value : null;
  useEffect(() => () => shown && URL.revokeObjectURL(shown.address), [shown]);
  const sight = useSight(store, session, shown);
  const at = store.frame.value?.stamp ?? 0;
  return (
    <div class="pictures stack">
      <SelectField
        title="Topic"
        value={topic}
        options={topics}
        onChange={(name) => {
          pictured.value = name;
        }}
      />
      {answer.kind === "failed" && <p role="alert">{answer.why}</p>}
      {answer.kind === "none" && (
        <div class="progress waiting wide" role="status" aria-label="The picture is being decoded">
          <span />
        </div>
      )}
      {shown && (
        <figure>
          <Marked src={shown.address} alt={`${topic} at ${shownTime(store, shown.seconds)}`} sight={sight} />
          <figcaption class="quiet">
            {shownTime(store, shown.seconds)}, {beside(shown.seconds - at)}
            {shown.isCloud && "; the cloud from above, x up and y to the left, lighter is higher"}
            {sight?.where && `; the selected place, on the floor, ${IS_SEEN[sight.where]}`}
            {sight?.why && `; the selected place is not marked: ${sight.why}`}
          </figcaption>
        </figure>
      )}
    </div>
  );
}

/** How far a time is from the moment of the map, s. */
const beside = (seconds: number): string =>
  Math.abs(seconds) < 0.0005 ? "at the moment of the map" : `${signed(seconds, 3)} s from the moment of the map`;

const IS_SEEN: Readonly<Record<NonNullable<CameraAnswer["where"]>, string>> = {
  inside: "is marked",
  outside: "lies outside of the picture",
  behind: "lies behind the camera",
};

/** The pixel of the selected place in a picture; null until it is known. */
function useSight(store: Store, session: string, shown: Shown | null): CameraAnswer | null {
  const sight = useSignal<CameraAnswer | null>(null);
  const trajectory = store.trajectory.value;
  const [x, y] = selectionOf(store).value?.place ?? [];
  useEffect(() => {
    sight.value = null;
    if (x === undefined || y === undefined || !shown || shown.isCloud) return;
    const { topic, seconds: at } = shown;
    const ending = new AbortController();
    ask(
      "GET /api/sessions/{session_id}/contents/camera",
      { session_id: session },
      { query: { topic, at, x, y }, ending: ending.signal },
    ).then(
      (answer) => {
        sight.value = answer;
      },
      () => undefined, // without an answer there is no mark
    );
    return () => ending.abort();
  }, [shown, x, y, trajectory]);
  return sight.value;
}

interface MarkedProps {
  readonly src: string;
  readonly alt: string;
  readonly sight: CameraAnswer | null;
}

/** A picture with a mark at the selected place, scaled as the picture. */
function Marked({ src, alt, sight }: MarkedProps) {
  const size = useSignal<readonly [width: number, height: number]>([1, 1]);
  const [width, height] = size.value;
  return (
    <div class="marked-picture">
      <img
        src={src}
        alt={alt}
        onLoad={({ currentTarget: { naturalWidth, naturalHeight } }) => {
          size.value = [naturalWidth, naturalHeight];
        }}
      />
      {sight?.where === "inside" && (
        <svg viewBox={`0 0 ${width} ${height}`} aria-hidden="true">
          <circle cx={sight.u * width} cy={sight.v * height} r={0.02 * Math.max(width, height)} />
        </svg>
      )}
    </div>
  );
}
