/** The colours of costs and of a potential, byte by byte. */

import { type Rgb, tokenRgb } from "../../style/colour";
import { fromLab, mixed, toLab } from "../../style/oklab";
import { plain } from "./palettes";

/** Byte of a cost in a grid: 0 is no information, 1 is free. */
export const byteOfCost = (cost: number): number => (cost === 255 ? 0 : cost + 1);
export const costOfByte = (byte: number): number => (byte === 0 ? 255 : byte - 1);

const INSCRIBED = 253;
const LETHAL = 254;
const BANDS = 24;

type Rgba = readonly [Rgb, number];

/** 256 RGBA colours, byte by byte. */
function row(colour: (byte: number) => Rgba): Uint8Array<ArrayBuffer> {
  const out = new Uint8Array(256 * 4);
  for (let byte = 0; byte < 256; byte++) {
    const [rgb, alpha] = colour(byte);
    out.set([...rgb, Math.round(255 * alpha)], byte * 4);
  }
  return plain(out);
}

/** The colour of a cost, and how much it hides of what is below. */
function ofCosts(isOver: boolean): (cost: number) => Rgba {
  // Reading a colour is slow: the browser computes the style of an element for it.
  const [unknown, free] = [tokenRgb("--map-unobserved"), tokenRgb("--surface")];
  const [lethal, inscribed] = [tokenRgb("--cost-lethal"), tokenRgb("--cost-inscribed")];
  const [low, high] = [toLab(tokenRgb("--cost-low")), toLab(tokenRgb("--cost-high"))];
  return (cost) => {
    if (cost === 255) return [unknown, isOver ? 0 : 0.35];
    if (cost === 0) return [free, isOver ? 0 : 0.75];
    if (cost === LETHAL) return [lethal, 0.95];
    if (cost === INSCRIBED) return [inscribed, 0.85];
    const share = cost / 252;
    return [fromLab(mixed(low, high, share)), isOver ? 0.25 + 0.6 * share : 0.85];
  };
}

/** A potential in bands, so that its fronts are seen. */
function ofPotential(): (byte: number) => Rgba {
  const surface = tokenRgb("--surface");
  const [low, high] = [toLab(tokenRgb("--robot-fill")), toLab(tokenRgb("--beam-fill"))];
  return (byte) => {
    if (byte === 0) return [surface, 0];
    const band = Math.floor(((byte - 1) / 255) * BANDS);
    return [fromLab(mixed(low, high, (byte - 1) / 254)), band % 2 === 0 ? 0.75 : 0.45];
  };
}

/** A speed limit, the denser the slower: the mask's value 1 … 100. */
function ofSpeed(): (value: number) => Rgba {
  const colour = tokenRgb("--speed-limit");
  return (value) => [colour, value > 100 ? 0 : 0.75 - 0.0045 * value];
}

export function costColours(isOver: boolean): Uint8Array<ArrayBuffer> {
  const colour = ofCosts(isOver);
  return row((byte) => colour(costOfByte(byte)));
}
export function speedColours(): Uint8Array<ArrayBuffer> {
  const colour = ofSpeed();
  return row((byte) => colour(costOfByte(byte)));
}
export const potentialColours = (): Uint8Array<ArrayBuffer> => row(ofPotential());
