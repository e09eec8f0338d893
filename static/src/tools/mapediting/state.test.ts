import { expect, test } from "vitest";
import { Store } from "../../store/store";
import { mapEditingOf } from "./state";

test("what was sent is drawn until it is in the map, or was refused", () => {
  const store = new Store(() => true);
  const editing = mapEditingOf(store);
  const edits = { type: "map_edits", n: 1, undone: 0, last: [], keepout_cells: 0, speed_cells: 0, notes: [] } as const;
  const draw = (isSent: boolean): void => {
    editing.sketch.value = [[1, 2]];
    editing.isSent.value = isSent;
  };
  draw(true);
  store.receive(edits);
  expect([editing.edits.value, editing.sketch.value, editing.isSent.value]).toEqual([edits, null, false]);
  draw(false);
  store.receive({ ...edits, n: 2 });
  expect(editing.sketch.value).toEqual([[1, 2]]);
  store.receive({ type: "error", code: "edit.op", message: "It is no edit.", detail: null });
  expect(editing.sketch.value).toBeNull();
  expect(mapEditingOf(store)).toBe(editing);
});
