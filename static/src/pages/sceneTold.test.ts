import { expect, test } from "vitest";
import { UntilTold } from "./sceneTold";

const AXES = { type: "SetSceneNodeVisibilityMessage", name: "/WorldAxes" };
const OTHER = { type: "SetSceneNodeVisibilityMessage", name: "/Map" };
const FIRST = { type: "SetCameraPositionMessage", initial: true };
const AIM = { type: "SetCameraPositionMessage", initial: false };

test("a scene is told once for each connection: that it has no axes, and from where it is seen", () => {
  const waiting = new UntilTold();
  expect(waiting.isTold([OTHER, AIM], true, false)).toBe(false);
  expect(waiting.isTold([OTHER, AXES], false, false)).toBe(false);
  expect(waiting.isTold([OTHER], true, false)).toBe(true);
  expect(waiting.isTold([AXES, AIM], true, false)).toBe(false);
  waiting.connected();
  expect(waiting.isTold([AIM], true, false)).toBe(false);
  expect(waiting.isTold([AXES], true, false)).toBe(true);
});

test("it is not told before the camera is aimed for the shape of the view, unless a person has moved the camera", () => {
  const waiting = new UntilTold();
  expect(waiting.isTold([AXES, FIRST], true, false)).toBe(false);
  expect(waiting.isTold([AIM], true, false)).toBe(true);
  expect(new UntilTold().isTold([AXES], true, true)).toBe(true);
});
