import { describe, expect, it } from "vitest";
import { cube, cut, denseCells, grown, type State, stateOf } from "./model";

/** The same by another way: all finest cells, pruned from below. */
function pruned(n: number, side: number): { leaves: number; inner: number } {
  let level: (State | null | "mixed")[] = Array.from({ length: n ** 3 }, (_, i) =>
    stateOf(cube((i % n) * side, (Math.floor(i / n) % n) * side, Math.floor(i / (n * n)) * side, side)),
  );
  let [leaves, inner] = [0, 0];
  for (let m = n; m > 1; m /= 2) {
    const half = m / 2;
    level = Array.from({ length: half ** 3 }, (_, i) => {
      const [x, y, z] = [2 * (i % half), 2 * (Math.floor(i / half) % half), 2 * Math.floor(i / (half * half))];
      const children = Array.from(
        { length: 8 },
        (_, k) => level[x + (k & 1) + m * (y + ((k >> 1) & 1)) + m * m * (z + (k >> 2))] ?? null,
      );
      if (children.every((child) => child === children[0]) && children[0] !== "mixed") return children[0] ?? null;
      inner++;
      leaves += children.filter((child) => child === "free" || child === "occupied").length;
      return "mixed";
    });
  }
  return { leaves, inner };
}

describe("the octree of the floor", () => {
  it("has the nodes of a dense grid that is pruned", () => {
    for (const [n, side] of [
      [16, 0.8],
      [32, 0.4],
      [64, 0.2],
    ] as const) {
      const { leaves, inner } = cut(grown(side), 1);
      expect({ leaves, inner }).toEqual(pruned(n, side));
    }
  });

  it("grows four times with half the side, a dense grid eight times", () => {
    const ratio = grown(0.1).leaves.length / grown(0.2).leaves.length;
    expect(ratio).toBeGreaterThan(2.5);
    expect(ratio).toBeLessThan(5.5);
    expect(denseCells(0.1) / denseCells(0.2)).toBeCloseTo(8, 1);
  });

  it("has the low table below the plane of the laser only, and the doors below their lintels", () => {
    const tree = grown(0.1);
    const at = (height: number, x: number, y: number) =>
      cut(tree, height).slice.find(
        (leaf) => x >= leaf.x && x < leaf.x + leaf.side && y >= leaf.y && y < leaf.y + leaf.side,
      )?.state;
    expect(at(0.2, 1.8, 5.7)).toBe("occupied");
    expect(at(0.45, 1.8, 5.7)).toBe("free");
    expect(at(1, 2.5, 3.23)).toBe("free");
    expect(at(2.3, 2.5, 3.23)).toBe("occupied");
  });
});
