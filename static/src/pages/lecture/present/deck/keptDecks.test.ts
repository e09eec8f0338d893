// @vitest-environment happy-dom
import { afterEach, expect, it, vi } from "vitest";
import type { Deck } from "./deck";
import { keepDeck, keptDeck } from "./keptDecks";

const deck = (title: string): Deck => ({ title, slides: [{ kind: "text", title: "Hello", text: "One" }] });

afterEach(() => {
  localStorage.clear();
  vi.useRealTimers();
});

it("keeps 30 decks, and removes the one that was not used for the longest time", () => {
  vi.useFakeTimers({ now: 1000 });
  localStorage.setItem("other", "1");
  const names = Array.from({ length: 30 }, (_, i) => {
    vi.advanceTimersByTime(1);
    return keepDeck(deck(`${i}`)) ?? "";
  });
  vi.advanceTimersByTime(1);
  keepDeck(keptDeck(names[0] ?? ""), names[0]);
  keepDeck(deck("30"));
  expect(keptDeck(names[0] ?? "")).toEqual(deck("0"));
  expect(() => keptDeck(names[1] ?? "")).toThrow("does not have the deck");
  expect(keptDeck(names[2] ?? "")).toEqual(deck("2"));
  expect(localStorage.length).toBe(31);
});
