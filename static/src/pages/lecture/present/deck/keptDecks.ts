/**
 * The decks that this browser stores. The address of the slides contains only the name of a deck, so that somebody who
 * reads the address on the screen, or gets a copy of it, sees neither the notes nor the hidden slides nor those to
 * come.
 */

import { type Deck, DeckError, readDeckFile, writtenDeck } from "./deck";

const PREFIX = "gridbloom.deck.";
/** Maximum number of stored decks. Those not opened or changed for the longest time are removed. */
const MOST = 30;

interface Kept {
  readonly name: string;
  readonly usedAt: number;
  /** The deck as in its file. */
  readonly text: string;
}

function allKept(): readonly Kept[] {
  return Object.keys(localStorage)
    .filter((key) => key.startsWith(PREFIX))
    .map((key) => {
      const item = localStorage.getItem(key) ?? "";
      const end = item.indexOf(" ");
      return { name: key.slice(PREFIX.length), usedAt: Number(item.slice(0, end)), text: item.slice(end + 1) };
    });
}

/**
 * Store a deck under `name`, and return its name. Without `name` it gets a new one, or that of an equal deck. Returns
 * null if the browser cannot store it.
 */
export function keepDeck(deck: Deck, name?: string): string | null {
  const text = JSON.stringify(writtenDeck(deck));
  try {
    const known = allKept();
    const called =
      name ?? known.find((deck) => deck.text === text)?.name ?? Math.random().toString(36).slice(2, 10).padEnd(8, "0");
    localStorage.setItem(PREFIX + called, `${Date.now()} ${text}`);
    const others = known.filter((deck) => deck.name !== called).toSorted((a, b) => b.usedAt - a.usedAt);
    for (const deck of others.slice(MOST - 1)) localStorage.removeItem(PREFIX + deck.name);
    return called;
  } catch {
    return null; // storage may be forbidden or full
  }
}

/** The deck called `name`. Throws a {@link DeckError} if this browser does not have it. */
export function keptDeck(name: string): Deck {
  let item: string | null = null;
  try {
    item = localStorage.getItem(PREFIX + name);
  } catch {
    // storage is forbidden
  }
  if (item === null)
    throw new DeckError("This browser does not have the deck of this address. Open the deck by its link or its file.");
  return readDeckFile(item.slice(item.indexOf(" ") + 1));
}
