/** The picture of a new world that the pages show until the server answers. */

import { decodeFrame } from "../wire/decodeFrame";
import type { ServerMessage } from "../wire/protocol";
import FIRST from "./firstPicture.json";
import { Store } from "./store";

/** Seed of the worlds that the pages begin: what a session with it sends first is recorded. */
export const FIRST_SEED = FIRST.seed;

/** A store that has received what a new world with {@link FIRST_SEED} sends first, and that sends nothing. */
export function firstPicture(): Store {
  const store = new Store(() => false);
  for (const message of FIRST.messages) store.receive(message as unknown as ServerMessage);
  store.take(decodeFrame(Uint8Array.from(atob(FIRST.tiles), (byte) => byte.charCodeAt(0)).buffer));
  return store;
}
