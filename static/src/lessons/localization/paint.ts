/** Paints particles and the likelihood field over the map of the stage. */

import { fieldLikelihood } from "../../grid/rangeModels";
import { tokenRgb } from "../../style/colour";
import type { Pose } from "../../wire/protocol";
import type { Projection } from "../stage/camera";
import { paintCells } from "../stage/paintCells";
import { distances, FIELD_GEOMETRY, MIXTURE } from "./field";

/** Radius of a dot, CSS pixels, on a stage with this scale, pixels per metre; smaller on a smaller stage. */
const DOT = 2.2;
const LARGE = 50;

interface CloudStyle {
  readonly weights: Float64Array;
  /** The number of random poses, at the end of the list. */
  readonly random: number;
}

/** Poses as dots with their heading: those with more weight are larger, random ones are rings of another colour. */
export function paintCloud(
  context: CanvasRenderingContext2D,
  at: Projection,
  poses: readonly Pose[],
  { weights, random }: CloudStyle,
): void {
  const most = weights.reduce((a, b) => Math.max(a, b), 0);
  const colours = { kept: tokenRgb("--beam"), random: tokenRgb("--hit") };
  const size = Math.min(1, Math.max(0.55, at.metre / LARGE));
  context.lineWidth = size;
  poses.forEach(([x, y, yaw], i) => {
    const share = most > 0 ? Math.sqrt((weights[i] ?? 0) / most) : 0;
    const isRandom = i >= poses.length - random;
    const [r, g, b] = isRandom ? colours.random : colours.kept;
    const [px, py] = [at.x(x), at.y(y)];
    context.globalAlpha = isRandom ? 0.85 : 0.3 + 0.6 * share;
    context.fillStyle = context.strokeStyle = `rgb(${r} ${g} ${b})`;
    context.beginPath();
    context.arc(px, py, size * DOT * (1 + 1.4 * share), 0, 2 * Math.PI);
    if (isRandom) context.stroke();
    else context.fill();
    context.beginPath();
    context.moveTo(px, py);
    context.lineTo(px + size * (5 + 6 * share) * Math.cos(yaw), py - size * (5 + 6 * share) * Math.sin(yaw));
    context.stroke();
  });
  context.globalAlpha = 1;
}

/** The likelihood field: the more likely an end point is in a cell, the more colour it has. */
export function paintField(context: CanvasRenderingContext2D, at: Projection): void {
  const [r, g, b] = tokenRgb("--hit-fill");
  const best = fieldLikelihood(0, MIXTURE);
  const least = fieldLikelihood(2, MIXTURE);
  const colours = new Uint8ClampedArray(4 * distances().length);
  distances().forEach((distance, i) => {
    const share = (fieldLikelihood(distance, MIXTURE) - least) / (best - least);
    colours.set([r, g, b, 235 * share], 4 * i);
  });
  paintCells(context, at, FIELD_GEOMETRY, colours);
}
