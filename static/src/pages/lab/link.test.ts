import { expect, test } from "vitest";
import { fragmentOf, groupFromAddress, type LinkState, linkFromAddress, packLink, unpackLink } from "./link";

const SHOWN: LinkState = {
  story: { world: "büro", seed: 123, steps: 700, journal: [[12, { type: "teleport", x: 1.25, y: -3 }]] },
  wrong: { on: ["no_clamp"], before: { clamp: true } },
  view: { x: 1.5, y: 2, scale: 0.01 },
  pinned: [1.25, 3],
  why: { at: [1.25, 3], touch: 7 },
  right: { clamp: true, mount_yaw: 0 },
  filter: { values: { sigma_hit: 0.05 }, map: "moved", field: true },
  map3d: { sensor: "depth_camera", voxel: 0.2 },
};

test("what is packed comes out again, in letters that an address may hold", async () => {
  const letters = await packLink(SHOWN);
  expect(letters).toMatch(/^[A-Za-z0-9_-]+$/);
  expect(await unpackLink(letters)).toEqual(SHOWN);
  expect(await linkFromAddress(await fragmentOf(SHOWN))).toEqual(SHOWN);
  expect(await linkFromAddress("")).toBeNull();
});

test("an older link without explained cell and second map still opens", async () => {
  const { pinned, why, right, filter, map3d, ...before } = SHOWN;
  expect(await unpackLink(await packLink(before as LinkState))).toEqual({
    ...before,
    pinned: null,
    why: null,
    right: null,
    filter: null,
    map3d: null,
  });
});

test("an address may name the group that is open at first", async () => {
  const fragment = `${await fragmentOf(SHOWN)}&group=map3d`;
  expect(groupFromAddress(fragment)).toBe("map3d");
  expect(await linkFromAddress(fragment)).toEqual(SHOWN);
  expect(groupFromAddress(await fragmentOf(SHOWN))).toBe("model");
});

test("a long story stays short", async () => {
  const journal = Array.from({ length: 300 }, (_, i) => [i * 4, { type: "teleport", x: 3 + 0.01 * i, y: 4 }] as const);
  expect((await packLink({ ...SHOWN, story: { ...SHOWN.story, journal } })).length).toBeLessThan(6000);
});

test("a link that lost a piece opens nothing, and one with a strange view shows everything", async () => {
  const letters = await packLink(SHOWN);
  expect(await unpackLink(letters.slice(0, letters.length / 2))).toBeNull();
  expect(await unpackLink("%%%")).toBeNull();
  expect(await unpackLink(await packLink({ ...SHOWN, story: { world: "x" } } as unknown as LinkState))).toBeNull();
  const odd = await unpackLink(await packLink({ ...SHOWN, view: { x: 1, y: 2, scale: -1 } }));
  expect(odd?.view).toBeNull();
  const strange = {
    ...SHOWN,
    pinned: [1, "2"],
    why: { at: [1, 2, 3] },
    right: { clamp: {} },
    filter: { values: {} },
  } as unknown as LinkState;
  expect(await unpackLink(await packLink(strange))).toMatchObject({
    pinned: null,
    why: null,
    right: null,
    filter: null,
  });
});
