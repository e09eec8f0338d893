import { expect, test } from "vitest";
import { consensus, momentsOf, type Place, planeOf, scoreOf, slopeWithoutRoot } from "./model";
import { PRESETS } from "./Patch";
import vectors from "./terrain.vectors.json";

test("moments, points that agree, and planes are those of the library", () => {
  expect(vectors.length).toBeGreaterThan(5);
  for (const { points, moments, agreeing, plane } of vectors) {
    expect(consensus(points as unknown as Place[], 0.1).map(Number)).toEqual(agreeing);
    const found = momentsOf(points as unknown as Place[]);
    moments.flat().forEach((entry, k) => {
      expect(found[k]).toBeCloseTo(entry, 9);
    });
    const ours = planeOf(found);
    if (plane === null) {
      expect(ours).toBeNull();
      continue;
    }
    expect(ours).not.toBeNull();
    for (const [name, value] of Object.entries(plane))
      expect(ours?.[name as keyof typeof ours], name).toBeCloseTo(value, 7);
  }
});

test("the plane of most points leaves the stone out, and least squares do not", () => {
  const stone = PRESETS.find(({ id }) => id === "stone")?.points ?? [];
  const used = consensus(stone, 0.05);
  expect(used.map((is, k) => (is ? -1 : k)).filter((k) => k >= 0)).toEqual([4]);
  const all = planeOf(momentsOf(stone));
  const some = planeOf(momentsOf(stone.filter((_, k) => used[k])));
  expect(all?.roughness).toBeGreaterThan(0.1);
  expect(some?.roughness).toBeLessThan(0.02);
});

test("twice as many points double the residual and leave roughness, slope and score as they are", () => {
  const points = PRESETS[1]?.points ?? [];
  const [once, twice] = [planeOf(momentsOf(points)), planeOf(momentsOf([...points, ...points]))];
  if (!once || !twice) throw new Error("no plane");
  expect(twice.residual).toBeCloseTo(2 * once.residual, 9);
  expect(twice.roughness).toBeCloseTo(once.roughness, 9);
  const limits = { slope: 0.35, roughness: 0.15 };
  expect(scoreOf(twice, limits)).toBeCloseTo(scoreOf(once, limits), 9);
});

test("without the root a ramp of 45° is one of 60°", () => {
  const ramp = planeOf(
    momentsOf([
      [-1, -1, -1],
      [1, -1, 1],
      [-1, 1, -1],
      [1, 1, 1],
    ]),
  );
  if (!ramp) throw new Error("no plane");
  expect((ramp.slope * 180) / Math.PI).toBeCloseTo(45);
  expect((slopeWithoutRoot(ramp) * 180) / Math.PI).toBeCloseTo(60);
});
