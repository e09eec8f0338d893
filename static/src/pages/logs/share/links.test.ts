// @vitest-environment happy-dom
import { expect, test } from "vitest";
import { described, type Link, linkOf } from "./links";

const link: Link = {
  token: "t",
  address: "/shared/t",
  created_s: 0,
  log: "l",
  topic: null,
  trajectory: "odom",
  index: 25,
  count: 40,
  changed: [],
  watching: 0,
};

test("a link says which view it opens and who looks", () => {
  expect(described(link)).toBe("25 of 40 scans · odometry");
  expect(described({ ...link, index: 40, topic: "/scan", changed: ["clamp"], watching: 1 })).toBe(
    "the whole log · odometry · /scan · 1 changed parameter · 1 viewer now",
  );
  expect(described({ ...link, changed: ["clamp", "window"], watching: 3 })).toBe(
    "25 of 40 scans · odometry · 2 changed parameters · 3 viewers now",
  );
  expect(described({ ...link, index: 40, trajectory: "/costmap_raw" }, "costmap")).toBe(
    "costmap 40 of 40 · /costmap_raw",
  );
});

test("a link's page is known by its address", () => {
  expect(linkOf("/shared/aB3-_x")).toBe("aB3-_x");
  expect([linkOf("/logs.html"), linkOf("/shared/"), linkOf("/shared/a/b"), linkOf("/x/shared/a")]).toEqual([
    null,
    null,
    null,
    null,
  ]);
});
