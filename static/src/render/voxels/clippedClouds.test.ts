import { expect, test } from "vitest";
import { ClippedClouds, clippingShader, type NodeMessage, PointClipper } from "./clippedClouds";

const POINTS = new Float32Array([0, 0, 0, 1, 2, 3]);
const cloud = (points = POINTS): NodeMessage => ({
  type: "PointCloudMessage",
  name: "/points/points",
  props: { points },
});
const corner = (end: string, position: readonly number[]): NodeMessage => ({
  type: "SetPositionMessage",
  name: `/points/clip_${end}`,
  position,
});

test("the box of a cloud is that of the node which it is in; its points are not copied", () => {
  const clouds = new ClippedClouds();
  const messages = [corner("low", [-9, -9, -9]), cloud()];
  clouds.take(messages);
  expect(messages[1]?.props?.points).toBe(POINTS);
  expect(clouds.pathOf(POINTS)).toBe("/points");
  expect(clouds.pathOf(POINTS.slice())).toBeUndefined();
  expect(clouds.boxOf("/points")).toBeNull(); // a corner is missing
  clouds.take([corner("high", [9, 9, 1])]);
  expect(clouds.boxOf("/points")).toEqual({ low: [-9, -9, -9], high: [9, 9, 1] });
  expect(clouds.take([corner("high", [9, 9, 2])])).toBe(true);
  expect(clouds.take([cloud()])).toBe(false);
  expect(clouds.boxOf("/points")?.high).toEqual([9, 9, 2]);
  clouds.take([{ type: "RemoveSceneNodeMessage", name: "/points" }]);
  expect(clouds.boxOf("/points")).toBeNull();
});

test("the shader of points tests the box at the end of its function, and no other shader does", () => {
  const points = "uniform float scale;\nvoid main() { gl_PointSize = scale; }\n";
  const clipping = clippingShader(points);
  expect(clipping).toMatch(/uniform highp vec3 clip_low;\nuniform highp vec3 clip_high;\nvoid main\(\) \{/);
  expect(clipping).toMatch(/gl_PointSize = scale;\s+if \(any\(lessThan\(position, clip_low\)\)[^}]*\}\n$/);
  const mesh = "void main() { gl_Position = vec4(position, 1.0); }";
  expect(clippingShader(mesh)).toBe(mesh);
});

test("each cloud is drawn with its box, and one without a box whole", () => {
  const clouds = new ClippedClouds();
  const clipper = new PointClipper(clouds);
  const bare = new Float32Array(3);
  clouds.take([cloud(), corner("low", [0, 0, 0]), corner("high", [1, 1, 1])]);
  clouds.take([{ type: "PointCloudMessage", name: "/features/points", props: { points: bare } }]);
  const [program, ours, other] = [{}, {}, {}];
  let [bound, drawn]: object[] = [ours, ours];
  const set: Record<string, readonly number[]> = {};
  const gl = {
    ARRAY_BUFFER_BINDING: 1,
    CURRENT_PROGRAM: 2,
    getParameter: (name: number) => (name === 1 ? bound : program),
    getUniformLocation: (_: object, name: string) => name,
    getAttribLocation: () => 0,
    getVertexAttrib: () => drawn,
    uniform3fv: (name: string, value: readonly number[]) => {
      set[name] = value;
    },
  } as unknown as WebGL2RenderingContext;
  clipper.wrote(gl, POINTS);
  bound = other;
  clipper.wrote(gl, bare);
  clipper.prepare(gl);
  expect(set).toEqual({ clip_low: [0, 0, 0], clip_high: [1, 1, 1] });
  drawn = other;
  clipper.prepare(gl);
  expect(set.clip_high?.every((value) => value > 1e38)).toBe(true);
});
