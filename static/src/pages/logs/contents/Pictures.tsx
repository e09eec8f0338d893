/** Images and clouds of the moment that the log is at. */

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Store } from "../../../store/store";
import { signed } from "../../../ui/numbers";
import { SelectField } from "../../../ui/Select";
import { addressOf, fetched } from "../../../wire/ask";
import { useAtMoment } from "./useAtMoment";
import { WhenKnown } from "./useContents";

interface PicturesProps {
  readonly store: Store;
  readonly session: string;
}

export function Pictures({ store, session }: PicturesProps) {
  return (
    <WhenKnown>
      {({ pictures }) =>
        pictures.length > 0 ? (
          <OfTopic store={store} session={session} topics={pictures} />
        ) : (
          <p class="quiet">The log has no images and no point clouds.</p>
        )
      }
    </WhenKnown>
  );
}

interface Shown {
  readonly address: string;
  readonly seconds: number;
  readonly isCloud: boolean;
}

/** Fetch a picture. Throws an error with the server's message if it is refused. */
async function fetchPicture(address: string, signal: AbortSignal): Promise<Shown> {
  const answer = await fetched(address, { signal });
  const seconds = Number(answer.headers.get("X-Picture-Seconds"));
  const picture = await answer.blob();
  return { address: URL.createObjectURL(picture), seconds, isCloud: picture.type === "image/png" };
}

function OfTopic({ store, session, topics }: PicturesProps & { readonly topics: readonly string[] }) {
  const topic = useSignal(topics[0] ?? "");
  const answer = useAtMoment<Shown>(
    store,
    (at) =>
      addressOf("GET /api/sessions/{session_id}/contents/picture", { session_id: session }, { topic: topic.value, at }),
    fetchPicture,
  );
  const shown = answer.kind === "ready" ? answer.value : null;
  useEffect(() => () => shown && URL.revokeObjectURL(shown.address), [shown]);
  const at = store.frame.value?.stamp ?? 0;
  return (
    <div class="pictures stack">
      <SelectField
        title="Topic"
        value={topic.value}
        options={topics}
        onChange={(name) => {
          topic.value = name;
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
          <img src={shown.address} alt={`${topic.value} at ${shown.seconds.toFixed(2)} s`} />
          <figcaption class="quiet">
            {signed(shown.seconds - at)} s from the moment of the map
            {shown.isCloud && "; the cloud from above, x up and y to the left, lighter is higher"}
          </figcaption>
        </figure>
      )}
    </div>
  );
}
