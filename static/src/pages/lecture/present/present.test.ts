// @vitest-environment happy-dom
import { afterEach, describe, expect, it, vi } from "vitest";
import { LESSONS, type LessonId } from "../lessons";
import { ANSWERS, OTHER_NOTES } from "./answers";
import { SHORT_LECTURE } from "./deck/DeckEditor";
import { type Slide, WHOLE_LECTURE } from "./deck/deck";
import { type Act, actOf, type Focused } from "./keys";
import { type Answer, QUESTIONS } from "./questions";
import { changeDeck, deck, deckLink, endOf, hashOf, place, presenting, readAddress, stepped, takeDeck } from "./state";

const nothing: Focused = { isText: false, usesArrows: false, usesSpace: false, by: null };
const slider = (by: Focused["by"]): Focused => ({ ...nothing, usesArrows: true, by });
const button = (by: Focused["by"]): Focused => ({ ...nothing, usesSpace: true, by });
const field: Focused = { ...nothing, isText: true, by: "mouse" };

describe("the keys of the presentation", () => {
  const cases: readonly (readonly [key: string, focused: Focused, act: Act | null])[] = [
    ["PageDown", nothing, "next"],
    ["PageDown", slider("mouse"), "next"],
    ["PageDown", slider("tab"), "next"],
    ["PageDown", field, "next"],
    ["PageUp", slider("touch"), "back"],
    ["ArrowRight", nothing, "next"],
    ["ArrowRight", slider("mouse"), "next"],
    ["ArrowLeft", slider("mouse"), "back"],
    ["ArrowRight", slider("tab"), null],
    ["ArrowUp", slider("touch"), null],
    ["ArrowRight", button("tab"), "next"],
    ["ArrowRight", field, null],
    [" ", nothing, "next"],
    [" ", button("mouse"), "next"],
    [" ", button("tab"), null],
    [" ", field, null],
    ["Home", nothing, "first"],
    ["End", slider("mouse"), "last"],
    ["End", slider("tab"), null],
    ["b", button("tab"), "blank"],
    [".", nothing, "blank"],
    ["b", field, null],
    ["Escape", nothing, "exit"],
    ["Escape", slider("mouse"), "exit"],
    ["Escape", slider("tab"), "release"],
    ["Escape", field, "release"],
    ["x", nothing, null],
  ];
  it.each(cases)("%s on %o", (key, focused, act) => expect(actOf(key, false, focused)).toBe(act));

  it("go a whole slide with Shift", () => {
    expect(actOf("ArrowRight", true, nothing)).toBe("nextSlide");
    expect(actOf("PageUp", true, nothing)).toBe("previousSlide");
    expect(actOf(" ", true, nothing)).toBe("back");
  });
});

describe("the steps", () => {
  const list: readonly Slide[] = [
    { kind: "section", section: "grid" },
    { kind: "section", section: "cell", hidden: true },
    { kind: "section", section: "rays" },
  ];
  const three = (): number => 3;
  const at = (index: number, step: number) => ({ index, step });

  it("lead through each slide that is not hidden, and end at the ends", () => {
    expect(stepped(at(0, 1), 1, false, list, three)).toEqual(at(0, 2));
    expect(stepped(at(0, 2), 1, false, list, three)).toEqual(at(2, 0));
    expect(stepped(at(2, 0), -1, false, list, three)).toEqual(at(0, 2));
    expect(stepped(at(2, 2), 1, false, list, three)).toEqual(at(2, 2));
    expect(stepped(at(0, 0), -1, false, list, three)).toEqual(at(0, 0));
    expect(stepped(at(0, 0), 1, true, list, three)).toEqual(at(2, 0));
    expect(stepped(at(2, 2), -1, true, list, three)).toEqual(at(0, 0));
    expect(endOf(list, false)).toEqual(at(2, 0));
  });
});

describe("the address", () => {
  afterEach(async () => {
    await takeDeck(WHOLE_LECTURE);
    localStorage.clear();
  });

  it("names slide and step, and opens them again", async () => {
    presenting.value = true;
    const rays = WHOLE_LECTURE.slides.findIndex((slide) => slide.kind === "section" && slide.section === "rays");
    expect(hashOf({ index: rays, step: 0 })).toBe("#rays");
    expect(hashOf({ index: rays, step: 2 })).toBe("#rays/3");
    location.hash = "#rays/3";
    await readAddress();
    expect(place.peek()).toEqual({ index: rays, step: 2 });
    location.hash = "#rays/99";
    await readAddress();
    expect(place.peek()).toEqual({ index: rays, step: 3 });
    location.hash = "#nosuch";
    await readAddress();
    expect(place.peek()).toEqual({ index: 0, step: 0 });
  });

  const own = {
    title: "Mine",
    slides: [{ kind: "text", title: "Hello", text: "One\n\nTwo", notes: "Greet." } as const],
  };

  it("names an own deck, which the browser keeps, under the same name while it is changed", async () => {
    presenting.value = true;
    await takeDeck(own, { index: 0, step: 1 });
    const hash = location.hash;
    expect(hash).toMatch(/^#own-text\/2&kept=\w{8}\.\d+$/);
    await changeDeck({ ...own, title: "Renamed" });
    expect(location.hash).not.toBe(hash);
    expect(location.hash.split(".")[0]).toBe(hash.split(".")[0]?.replace("/2", ""));
    await takeDeck(WHOLE_LECTURE);
    location.hash = hash;
    await readAddress();
    expect(deck.peek()).toEqual({ ...own, title: "Renamed" });
    expect(place.peek()).toEqual({ index: 0, step: 1 });
    await takeDeck(own);
    expect(location.hash.split(".")[0]).not.toBe(hash.split(".")[0]?.replace("/2", ""));
  });

  it("takes the deck of a link in, and keeps the present one where the link is damaged or the name unknown", async () => {
    presenting.value = true;
    const link = new URL(await deckLink(own)).hash.replace("#", "#own-text/2");
    expect(link).toMatch(/^#own-text\/2&deck=[\w-]+$/);
    const opened = async (hash: string): Promise<string> => {
      location.hash = hash;
      await readAddress();
      return (/kept=(\w+)/.exec(location.hash) ?? [])[1] ?? "";
    };
    const name = await opened(link);
    expect(location.hash).toMatch(/^#own-text\/2&kept=/);
    expect(deck.peek()).toEqual(own);
    expect(await opened(link)).toBe(name);
    await expect(opened(link.slice(0, -9))).rejects.toThrow("damaged");
    await expect(opened("#own-text&kept=nosuch00.1")).rejects.toThrow("does not have the deck");
    expect(deck.peek()).toEqual(own);
  });

  it("holds the deck where the browser keeps nothing", async () => {
    presenting.value = true;
    vi.stubGlobal("localStorage", undefined);
    await takeDeck(own);
    vi.unstubAllGlobals();
    expect(location.hash).toMatch(/^#own-text&deck=[\w-]+$/);
  });
});

it("every section has a question", () => {
  expect(LESSONS.map(({ id }) => id).filter((id) => !QUESTIONS[id])).toEqual([]);
});

it("every slide of the lecture has notes, and so has the log of the short one", () => {
  for (const slide of SHORT_LECTURE.slides) {
    const name = slide.kind === "derivation" ? `${slide.section}-derivation` : slide.kind;
    const notes = slide.kind === "section" ? ANSWERS[slide.section]?.notes : OTHER_NOTES[name];
    expect(notes?.length, name).toBeGreaterThan(40);
  }
});

it("every question has an answer, and every right option is one of the options", () => {
  expect(Object.keys(ANSWERS)).toEqual(Object.keys(QUESTIONS));
  for (const [id, { question, options }] of Object.entries(QUESTIONS)) {
    const { right, answer, notes = "" } = ANSWERS[id as LessonId] as Answer;
    expect(question, id).toMatch(/\?$/);
    expect(options?.[right ?? -1] !== undefined, id).toBe(options !== undefined);
    // a line of the bar each
    expect(question.length, id).toBeLessThanOrEqual(78);
    expect(answer.length, id).toBeLessThanOrEqual(112);
    expect(notes.length, id).toBeGreaterThan(40);
  }
});
