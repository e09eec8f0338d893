// @vitest-environment happy-dom
import { signal } from "@preact/signals";
import { describe, expect, test } from "vitest";
import { ProfileView } from "./view";

describe("the reading that the profile shows", () => {
  test("follows the beam, stands still under a pointer, and follows again", () => {
    const reading = signal<number | null | undefined>(2);
    const view = new ProfileView(signal({}), reading);
    reading.value = 3;
    expect(view.z.value).toBe(3);
    view.setPointer(true);
    reading.value = 4;
    expect(view.z.value).toBe(3);
    view.setPointer(true); // entered again, from a handle say: it still is the reading of the first moment
    expect(view.z.value).toBe(3);
    view.setPointer(false);
    expect(view.z.value).toBe(4);
    view.dispose();
  });

  test("is the hand's once it was grabbed", () => {
    const reading = signal<number | null | undefined>(2);
    const view = new ProfileView(signal({}), reading);
    view.setPointer(true);
    view.grabbed.value = 5;
    expect(view.z.value).toBe(5);
    view.setPointer(false);
    expect(view.z.value).toBe(5);
    view.dispose();
  });
});
