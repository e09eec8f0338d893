/** The initial picture of a new world, shown until the server answers. */

import { decodeFrame } from "../wire/decodeFrame";
import type { ServerMessage } from "../wire/protocol";
import FIRST from "./firstPicture.json";
import { Store } from "./store";

/** Seed of the worlds that the pages begin. The first messages of a session with this seed are recorded. */
export const FIRST_SEED = FIRST.seed;

/** A store that has received the first messages of a new world with {@link FIRST_SEED}, and that sends nothing. */
export function firstPicture(): Store {
  const store = new Store(() => false);
  for (const message of FIRST.messages) store.receive(message as unknown as ServerMessage);
  store.take(decodeFrame(Uint8Array.from(atob(FIRST.tiles), (byte) => byte.charCodeAt(0)).buffer));
  return store;
}
