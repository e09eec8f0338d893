import { describe, expect, it } from "vitest";
import { LESSONS } from "./lessons";
import { keyedSlide, show, slide } from "./present";

describe("the presentation mode", () => {
  it("goes on and back by the keys of a clicker and of a keyboard, and stays at the ends", () => {
    for (const key of ["ArrowRight", "PageDown", " "]) expect(keyedSlide(key, false, 3, 13)).toBe(4);
    for (const key of ["ArrowLeft", "PageUp"]) expect(keyedSlide(key, false, 3, 13)).toBe(2);
    expect(keyedSlide(" ", true, 3, 13)).toBe(2);
    expect(keyedSlide("ArrowLeft", false, 0, 13)).toBe(0);
    expect(keyedSlide("End", false, 0, 13)).toBe(12);
    expect(keyedSlide("Home", false, 12, 13)).toBe(0);
    expect(keyedSlide("a", false, 3, 13)).toBeNull();
  });

  it("keeps the section in the address", () => {
    show(LESSONS, 4);
    expect(location.hash).toBe("#rays");
    show(LESSONS, 99);
    expect(slide.peek()).toBe(LESSONS.length - 1);
    expect(location.hash).toBe("#log");
  });
});
