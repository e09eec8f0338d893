import { expect, test } from "vitest";
import type { LocalizationMessage, Values } from "../../wire/protocol";
import { FilterSettings } from "./state";

const message = (values: Values, map = "plan", is_on = true): LocalizationMessage =>
  ({ type: "localization", is_on, values, map }) as unknown as LocalizationMessage;

test("answers to older commands of one's own change nothing, what others set is taken over", () => {
  const filter = new FilterSettings();
  for (const z_hit of [0.1, 0.2, 0.3]) filter.note({ type: "localize", value: true, values: { z_hit }, map: "plan" });
  filter.take(message({ z_hit: 0.1 }));
  expect(filter.values.peek()).toEqual({ z_hit: 0.3 });
  filter.take(message({ z_hit: 0.3 }));
  filter.take(message({ z_hit: 0.3 }));
  expect(filter.values.peek()).toEqual({ z_hit: 0.3 });
  // An answered command is forgotten: its values from elsewhere are new.
  filter.take(message({ z_hit: 0.1 }));
  expect(filter.values.peek()).toEqual({ z_hit: 0.1 });
  filter.take(message({ alpha1: 1 }, "moved"));
  expect([filter.values.peek(), filter.map.peek()]).toEqual([{ alpha1: 1 }, "moved"]);
});

test("the end of the filter leaves what is wanted", () => {
  const filter = new FilterSettings();
  filter.note({ type: "localize", value: true, values: { z_hit: 0.1 }, map: "moved" });
  filter.take(message({}, "plan", false));
  expect([filter.values.peek(), filter.map.peek()]).toEqual([{ z_hit: 0.1 }, "moved"]);
});
