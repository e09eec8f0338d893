// @vitest-environment happy-dom
import { describe, expect, it } from "vitest";
import { pack } from "../../../packed";
import { LESSONS } from "../../lessons";
import { DeckError, readDeck, readDeckFile, readDeckLink, slideIds, WHOLE_LECTURE, writtenDeck } from "./deck";

const deck = (slides: unknown): unknown => ({ gridbloom_deck: 1, title: "Mine", slides });

describe("a deck", () => {
  it("holds every section of the lecture, its derivations and the lab", () => {
    const sections = WHOLE_LECTURE.slides.filter(({ kind }) => kind === "section");
    expect(sections.map((slide) => "section" in slide && slide.section)).toEqual(LESSONS.map(({ id }) => id));
    expect(WHOLE_LECTURE.slides.map(({ kind }) => kind)).toEqual(expect.arrayContaining(["derivation", "lab"]));
  });

  it("comes back from its file and from its link as it was", async () => {
    const own = {
      title: "Lecture 7: maps ℓ₀",
      slides: [
        { kind: "text", title: "Today", text: "First\n\nSecond", notes: "Greet." },
        { kind: "section", section: "cell", hidden: true },
        { kind: "derivation", section: "cell" },
        { kind: "lab", title: "Lab", address: "/lab.html#s=abc" },
        { kind: "log", title: "Log", address: "/logs.html?log=1#x" },
        { kind: "log", title: "Shared", address: "/shared/abc" },
      ],
    } as const;
    expect(readDeckFile(JSON.stringify(writtenDeck(own)))).toEqual(own);
    expect(await readDeckLink(await pack(writtenDeck(own)))).toEqual(own);
    expect(readDeck(writtenDeck(WHOLE_LECTURE))).toEqual(WHOLE_LECTURE);
  });

  it("names its slides so that no two have the same name", () => {
    const text = { kind: "text", title: "a", text: "b" } as const;
    const ids = slideIds({ title: "", slides: [text, { kind: "section", section: "rays" }, text, text] });
    expect(ids).toEqual(["own-text", "rays", "own-text-2", "own-text-3"]);
    const whole = slideIds(WHOLE_LECTURE);
    expect(new Set(whole).size).toBe(whole.length);
  });

  const shown = { kind: "section", section: "grid" };
  it.each([
    ["not JSON", "{", "The file is not JSON"],
    ["a list", "[]", "“gridbloom_deck” is missing"],
    ["another JSON file", '{"a": 1}', "“gridbloom_deck” is missing"],
    ["a newer version", '{"gridbloom_deck": 2}', "version 2; this page reads version 1"],
    ["no title", '{"gridbloom_deck": 1, "slides": []}', "The deck: “title” is missing"],
    ["no slides", '{"gridbloom_deck": 1, "title": "a"}', "“slides” is missing"],
    ["nothing to show", deck([{ ...shown, hidden: true }]), "no slide that is shown"],
    ["a text for a slide", deck(["grid"]), "Slide 1 is not an object"],
    ["an unknown kind", deck([shown, { kind: "video" }]), "Slide 2: the kind “video” is not known"],
    ["an unknown section", deck([{ kind: "section", section: "gird" }]), "no section “gird”"],
    ["no such derivation", deck([{ kind: "derivation", section: "file" }]), "“file” has no derivation"],
    ["an empty text", deck([{ kind: "text", title: "a", text: " " }]), "Slide 1: “text” is empty"],
    ["a number as title", deck([{ kind: "text", title: 3, text: "b" }]), "“title” is missing or is not a text"],
    ["a long title", deck([{ kind: "text", title: "a".repeat(121), text: "b" }]), "has 121 characters; at most 120"],
    ["a hidden that is a word", deck([{ ...shown, hidden: "yes" }]), "“hidden” is neither true nor false"],
    ["another host", deck([{ kind: "lab", title: "a", address: "https://example.org/lab.html" }]), "of example.org"],
    ["a script", deck([{ kind: "lab", title: "a", address: "javascript:alert(1)" }]), "only pages of this service"],
    ["another page", deck([{ kind: "log", title: "a", address: "/lab.html" }]), "/lab.html is not a page of the logs"],
    ["no address", deck([{ kind: "log", title: "a", address: "http://" }]), "“http://” is not an address"],
    ["too many slides", deck(Array(201).fill(shown)), "201 slides; at most 200"],
    ["too long a file", `"${"a".repeat(1_000_000)}"`, "1000002 characters; a deck has at most 1000000"],
  ])("is refused with a reason: %s", (_, bad, reason) => {
    const text = typeof bad === "string" ? bad : JSON.stringify(bad);
    expect(() => readDeckFile(text)).toThrow(DeckError);
    expect(() => readDeckFile(text)).toThrow(reason);
  });

  it("is refused where its link is cut off", async () => {
    const letters = await pack(writtenDeck(WHOLE_LECTURE));
    await expect(readDeckLink(letters.slice(0, -20))).rejects.toThrow("incomplete or damaged");
    await expect(readDeckLink("%%%")).rejects.toThrow("incomplete or damaged");
  });
});
