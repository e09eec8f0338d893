// @vitest-environment happy-dom
import { expect, it } from "vitest";
import { LECTURE_PARTS } from "../../lessons";
import { SHORT_LECTURE } from "./DeckEditor";
import { readDeck, slideIds, WHOLE_LECTURE, writtenDeck } from "./deck";
import { allShown, onlyPart } from "./deckOrder";

it("is planned for 45 minutes on 16 to 18 slides, from the filter to the use of the map", () => {
  const shown = SHORT_LECTURE.slides.filter(({ hidden }) => !hidden);
  expect(shown.length).toBeGreaterThanOrEqual(16);
  expect(shown.length).toBeLessThanOrEqual(18);
  expect(shown.reduce((sum, { minutes = 0 }) => sum + minutes, 0)).toBe(45);
  const names = slideIds({ title: "", slides: shown });
  const order = [
    "own-title",
    "cell",
    "cell-derivation",
    "model",
    "no-return",
    "rays",
    "own-log",
    "mount",
    "path",
    "next",
  ];
  expect(names.filter((name) => order.includes(name))).toEqual(order);
  expect(readDeck(writtenDeck(SHORT_LECTURE))).toEqual(SHORT_LECTURE);
});

it("refuses minutes that are no time", () => {
  for (const minutes of [0, -1, 601, "3"])
    expect(() =>
      readDeck({ gridbloom_deck: 1, title: "t", slides: [{ kind: "section", section: "cell", minutes }] }),
    ).toThrow("minutes");
});

it("keeps the title slide of a part, with the part's name, until all are shown", () => {
  const [first, second] = LECTURE_PARTS;
  if (!first || !second) throw new Error("no parts");
  const once = onlyPart(WHOLE_LECTURE.slides, first);
  const twice = onlyPart(once, second).filter(({ hidden }) => !hidden);
  expect(once[0]).toEqual({ kind: "title", title: "Occupancy grid mapping: Mapping" });
  expect(twice[0]).toEqual({ kind: "title", title: "Occupancy grid mapping: When it goes wrong" });
  expect(twice[1]).toEqual({ kind: "section", section: "mount" });
  expect(allShown(once)).toEqual(WHOLE_LECTURE.slides);
});
