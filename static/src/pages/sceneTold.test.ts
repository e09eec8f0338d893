import { expect, test } from "vitest";
import { UntilTold } from "./sceneTold";

const AXES = { type: "SetSceneNodeVisibilityMessage", name: "/WorldAxes" };
const OTHER = { type: "SetSceneNodeVisibilityMessage", name: "/Map" };

test("a scene is told once for each connection: that it has no axes, and from where it is seen", () => {
  const waiting = new UntilTold();
  expect(waiting.isTold([OTHER], true)).toBe(false);
  expect(waiting.isTold([OTHER, AXES], false)).toBe(false);
  expect(waiting.isTold([OTHER], true)).toBe(true);
  expect(waiting.isTold([AXES], true)).toBe(false);
  waiting.connected();
  expect(waiting.isTold([OTHER], true)).toBe(false);
  expect(waiting.isTold([AXES], true)).toBe(true);
});
