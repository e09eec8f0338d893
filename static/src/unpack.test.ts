import { describe, expect, test } from "vitest";
import { decodeTiles } from "./decodeTiles";
import vectors from "./protocol.vectors.json";
import { unpack } from "./unpack";

const bytes = (hex: string): Uint8Array<ArrayBuffer> =>
  Uint8Array.from({ length: hex.length / 2 }, (_, i) => Number.parseInt(hex.slice(2 * i, 2 * i + 2), 16));
const text = (block: Uint8Array, size: number): string => {
  const out = new Uint8Array(size);
  unpack(block, out);
  return new TextDecoder().decode(out);
};
/** A token, the literals, and a match. */
const sequence = (literals: string, back: number, matched: number): number[] => [
  (literals.length << 4) | (matched - 4),
  ...new TextEncoder().encode(literals),
  back & 255,
  back >> 8,
];

describe("a block of LZ4", () => {
  test("literals and matches, by the format's description", () => {
    expect(text(Uint8Array.of(0x30, 97, 98, 99), 3)).toBe("abc");
    expect(text(Uint8Array.from([...sequence("abc", 3, 6), 0x10, 33]), 10)).toBe("abcabcabc!");
    expect(text(Uint8Array.from([...sequence("ab", 1, 5), 0x10, 33]), 8)).toBe("abbbbbb!");
  });

  test("lengths that go on, up to 255 and beyond", () => {
    for (const n of [14, 15, 16, 269, 270, 271, 600]) {
      const rest = n - 15;
      const more = rest < 0 ? [] : [...Array(Math.floor(rest / 255)).fill(255), rest % 255];
      const literals = Uint8Array.from([Math.min(n, 15) << 4, ...more, ...Array(n).fill(120)]);
      expect(text(literals, n)).toBe("x".repeat(n));
      const match = Uint8Array.from([0x10 | Math.min(n, 15), 120, 1, 0, ...more, 0x10, 121]);
      expect(text(match, n + 6)).toBe(`${"x".repeat(n + 5)}y`);
    }
  });

  test("an empty block holds nothing", () => {
    expect(text(new Uint8Array(0), 0)).toBe("");
    expect(() => text(new Uint8Array(0), 1)).toThrow(RangeError);
  });

  test.each([
    ["literals that are missing", [0x30, 97, 98], 3],
    ["literals for which there is no room", [0x30, 97, 98, 99], 2],
    ["a length that never ends", [0xf0, 255, 255], 600],
    ["half of an offset", [0x11, 97, 1], 6],
    ["an offset of 0", [0x11, 97, 0, 0, 0x10, 98], 7],
    ["a match before the beginning", [0x11, 97, 2, 0, 0x10, 98], 7],
    ["a match for which there is no room", [0x1f, 97, 1, 0, 200, 0x10, 98], 30],
    ["less than was promised", [0x30, 97, 98, 99], 4],
  ])("refused: %s", (_, block, size) => {
    expect(() => text(Uint8Array.from(block), size)).toThrow(RangeError);
  });

  test("what the server writes, cut anywhere or with a byte changed, is refused or a tile, and nothing else", () => {
    const { hex } = vectors.frames[1] as { hex: string };
    const { data } = decodeTiles(bytes(hex).buffer).tiles[0] as { data: Uint8Array };
    for (let n = 0; n < data.length; n++) expect(() => unpack(data.subarray(0, n), new Uint8Array(4096))).toThrow();
    for (let at = 0; at < data.length; at++) {
      const broken = data.slice();
      broken[at] = (broken[at] as number) ^ 0xff;
      try {
        unpack(broken, new Uint8Array(4096));
      } catch (error) {
        expect(error).toBeInstanceOf(RangeError);
      }
    }
  });
});
