import { expect, test } from "vitest";
import { Store } from "../../store/store";
import type { Command } from "../../wire/protocol";
import { measuringOf } from "./measuring";
import { measureInScenes } from "./tool";

/** A page whose 3D views tell places, and what it sent. */
function page() {
  const sent: Command[] = [];
  const store = new Store((command) => {
    sent.push(command);
    return true;
  });
  measureInScenes(store);
  const click = (x: number, y: number, z: number | null, size: number | null): void =>
    store.receive({ type: "place", x, y, z, size });
  return { store, measuring: measuringOf(store), sent, click };
}

test("places that are clicked in 3D are measured and drawn there, from when a tool is taken", () => {
  const { measuring, sent, click } = page();
  click(9, 9, 9, 0.1);
  expect(sent).toEqual([]);
  measuring.take("area");
  expect(sent.at(-1)).toEqual({ type: "measure", points: [], closed: true });
  click(1, 2, 3, 0);
  click(1, 2, 3, 0.1);
  expect(measuring.points.peek()).toEqual([
    [1, 2, 3],
    [1, 2, 3],
  ]);
  expect(measuring.size.peek()).toBe(0.1);
  expect(measuring.onMap.peek()).toEqual([
    [1, 2],
    [1, 2],
  ]);
  measuring.undo();
  expect(sent.at(-1)).toEqual({ type: "measure", points: [[1, 2, 3]], closed: true });
  measuring.take(null);
  expect(sent.at(-1)).toEqual({ type: "measure" });
});

test("a place of a plane map is measured as one that is clicked on the map", () => {
  const { measuring, sent, click } = page();
  measuring.take("distance");
  click(1, 2, null, null);
  click(4, 6, null, null);
  expect(measuring.points.peek()).toEqual([
    [1, 2],
    [4, 6],
  ]);
  expect(measuring.size.peek()).toBeNull();
  expect(sent.at(-1)).toEqual({
    type: "measure",
    points: [
      [1, 2, 0],
      [4, 6, 0],
    ],
    closed: false,
  });
});
