// @vitest-environment happy-dom
import { expect, test } from "vitest";
import { shownSlide, slideOfMessage } from "./classSlides";
import type { Slide } from "./deck/deck";

const TEXT: Slide = { kind: "text", title: "Mine", text: "One\n\nTwo\n\nThree", notes: "private", hidden: true };

test("followers get the paragraphs so far, and neither notes nor what the deck says of the slide", () => {
  expect(shownSlide(TEXT, 0)).toEqual({ kind: "text", title: "Mine", text: "One" });
  expect(shownSlide(TEXT, 1)).toEqual({ kind: "text", title: "Mine", text: "One\n\nTwo" });
  const section: Slide = { kind: "section", section: "cell", notes: "private" };
  expect(shownSlide(section, 2)).toEqual({ kind: "section", section: "cell" });
  expect(shownSlide(section, 3, "They add up.")).toEqual({ kind: "section", section: "cell", text: "They add up." });
});

test("followers get the address of a shared view, and none of the lab or of a log", () => {
  const page = (kind: "lab" | "log", address: string): Slide => ({ kind, title: "A page", address });
  expect(shownSlide(page("lab", "/lab.html?session=secret"), 0)).toEqual({ kind: "lab", title: "A page" });
  expect(shownSlide(page("log", "/logs.html?log=secret"), 0)).toEqual({ kind: "log", title: "A page" });
  expect(shownSlide(page("log", "/shared/abc"), 0)).toEqual({ kind: "log", title: "A page", address: "/shared/abc" });
});

test("what followers get is a slide again, and no address of another host is taken", () => {
  expect(slideOfMessage(shownSlide(TEXT, 1))).toEqual({ kind: "text", title: "Mine", text: "One\n\nTwo" });
  expect(slideOfMessage({ kind: "lab", title: "A page" })).toEqual({ kind: "lab", title: "A page", address: "" });
  expect(slideOfMessage({ kind: "section", section: "of another version" })).toBeNull();
  expect(() => slideOfMessage({ kind: "log", title: "", address: "https://example.org/shared/x" })).toThrow("address");
});
