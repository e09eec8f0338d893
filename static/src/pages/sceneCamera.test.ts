// @vitest-environment happy-dom
import { beforeEach, expect, test } from "vitest";
import { FirstCamera, keptCamera, keptQuery, MovedCamera } from "./sceneCamera";

const PATH = "/scenes/abc/plain/page/";
const at = (pathname: string, search = ""): Location => ({ pathname, search }) as Location;

beforeEach(() => sessionStorage.clear());

const reported = (x: number) => ({
  type: "ViewerCameraMessage",
  position: [x, -2, 3],
  look_at: [0, 0.25, 0],
  fov: 0.8,
});
const TOLD = [{ type: "SetCameraPositionMessage", initial: false }];

test("a view begins where a person has moved the camera of its session, in any page of the tab", () => {
  expect(keptQuery(sessionStorage, at(PATH))).toBeNull();
  const camera = new MovedCamera(sessionStorage, PATH, false);
  camera.reports(reported(1));
  camera.acted();
  expect(camera.reports(reported(1.5))).toBe(true);
  const query = new URLSearchParams(keptQuery(sessionStorage, at("/scenes/abc/plain/other/", "?darkMode")) ?? "");
  expect(query.get("initialCameraPosition")).toBe("1.5,-2,3");
  expect(query.get("initialCameraLookAt")).toBe("0,0.25,0");
  expect(query.has("darkMode")).toBe(true);
  expect(keptQuery(sessionStorage, at("/scenes/another/plain/page/"))).toBeNull();
  expect(keptCamera(sessionStorage, PATH)).toEqual({ position: [1.5, -2, 3], look_at: [0, 0.25, 0] });
});

test("a camera is moved by a person alone, until the server tells it a place, and that is reported once", () => {
  const camera = new MovedCamera(sessionStorage, PATH, false);
  expect(camera.reports(reported(1))).toBe(false);
  expect(camera.reports(reported(2))).toBe(false); // viser's client has gone to its first camera
  camera.acted();
  expect(camera.reports(reported(2))).toBe(false); // its picture has another shape
  expect(camera.reports(reported(3))).toBe(true);
  expect(camera.reports(reported(4))).toBe(false);
  camera.connected();
  expect(camera.reports(reported(4))).toBe(true);
  camera.take([{ type: "SetCameraPositionMessage", initial: true }]);
  expect(keptCamera(sessionStorage, PATH)?.position[0]).toBe(4);
  camera.take(TOLD);
  expect(camera.reports(reported(5))).toBe(false);
  expect(keptCamera(sessionStorage, PATH)).toBeNull();
  expect(new MovedCamera(null, PATH, true).reports(reported(1))).toBe(true);
});

test("other messages, and what is no camera, are not kept", () => {
  const camera = new MovedCamera(sessionStorage, PATH, true);
  camera.reports({ ...reported(1), type: "ScenePointerMessage" });
  camera.reports(reported(Number.NaN));
  camera.reports(undefined);
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
