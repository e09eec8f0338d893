// @vitest-environment happy-dom
import { beforeEach, expect, test } from "vitest";
import { FirstCamera, keepCamera, keptCamera, keptQuery } from "./sceneCamera";

const PATH = "/scenes/abc/plain/page/";
const at = (pathname: string, search = ""): Location => ({ pathname, search }) as Location;

beforeEach(() => sessionStorage.clear());

test("a view begins where the camera of its session was, in any page of the tab", () => {
  expect(keptQuery(sessionStorage, at(PATH))).toBeNull();
  keepCamera(sessionStorage, PATH, {
    type: "ViewerCameraMessage",
    position: [1.5, -2, 3],
    look_at: [0, 0.25, 0],
    fov: 0.8,
  });
  const query = new URLSearchParams(keptQuery(sessionStorage, at("/scenes/abc/plain/other/", "?darkMode")) ?? "");
  expect(query.get("initialCameraPosition")).toBe("1.5,-2,3");
  expect(query.get("initialCameraLookAt")).toBe("0,0.25,0");
  expect(query.has("darkMode")).toBe(true);
  expect(keptQuery(sessionStorage, at("/scenes/another/plain/page/"))).toBeNull();
  expect(keptCamera(sessionStorage, PATH)).toEqual({ position: [1.5, -2, 3], look_at: [0, 0.25, 0] });
});

test("other messages, and what is no camera, are not kept", () => {
  keepCamera(sessionStorage, PATH, { type: "ScenePointerMessage", position: [1, 2, 3], look_at: [0, 0, 0] });
  keepCamera(sessionStorage, PATH, { type: "ViewerCameraMessage", position: [1, 2, Number.NaN], look_at: [0, 0, 0] });
  keepCamera(sessionStorage, PATH, undefined);
  expect(sessionStorage.length).toBe(0);
  for (const text of ["null", "{", '{"position":[1,2,3]}', '{"position":[1,2,"3"],"look_at":[0,0,0]}']) {
    sessionStorage.setItem("gridbloom.camera.abc", text);
    expect(keptQuery(sessionStorage, at(PATH))).toBeNull();
  }
});

test("the messages about the first camera are passed on together, the newest of each", () => {
  const first = new FirstCamera();
  const up = { type: "SetCameraUpDirectionMessage", initial: true };
  const position = { type: "SetCameraPositionMessage", initial: true };
  const newer = { ...position };
  const lookAt = { type: "SetCameraLookAtMessage", initial: true };
  const told = { ...position, initial: false };
  const other = { type: "FrameMessage" };
  const batches = [[up, other], [position], [told, newer, lookAt, other], [up]];
  for (const batch of batches) first.take(batch);
  expect(batches).toEqual([[other], [], [told, other, up, newer, lookAt], [up]]);
  expect(batches[2]?.[3]).toBe(newer);
});
