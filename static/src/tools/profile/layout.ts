/**
 * Layout of the profile figure, in CSS pixels: the whole beam on top, below it the enlarged part around the reading
 * with the curve, and below that the cells of the same part on the same axis.
 */

export interface Box {
  readonly left: number;
  readonly right: number;
  readonly top: number;
  readonly bottom: number;
}

export interface Layout {
  readonly width: number;
  readonly height: number;
  readonly beam: Box;
  readonly curve: Box;
  readonly strip: Box;
}

/** Least height of the curve; below it the figure is truncated instead. */
const LEAST_CURVE = 60;

/** The layout for a width, and for a height if the figure's container has one: its parts are then closer together. */
export function layoutFor(width: number, height: number | null = null): Layout {
  const narrow = width < 560;
  const left = narrow ? 56 : 62;
  const right = width - (narrow ? 54 : 62);
  const tight = height !== null;
  const beamTop = tight ? 18 : 30;
  const beam = { left, right, top: beamTop, bottom: beamTop + (tight ? 24 : 28) };
  const top = beam.bottom + (tight ? 32 : 44);
  const above = tight ? 28 : 30;
  const cells = tight ? 18 : 30;
  const below = tight ? 36 : 62;
  const curveHeight = tight ? Math.max(LEAST_CURVE, height - top - above - cells - below) : narrow ? 220 : 240;
  const curve = { left, right, top, bottom: top + curveHeight };
  const strip = { left, right, top: curve.bottom + above, bottom: curve.bottom + above + cells };
  return { width, height: strip.bottom + below, beam, curve, strip };
}

/** The enlarged part of the beam, in metres. */
export interface Lens {
  readonly start: number;
  readonly span: number;
}

/** Length of the enlarged part: cells of about 16 px, longer for a wide window, at most the whole beam. */
export function lensSpan(resolution: number, window: number, total: number, width: number): number {
  const cells = Math.min(60, Math.max(20, Math.round(width / 16)));
  return Math.min(total, Math.max(cells * resolution, 1.8 * window));
}

/**
 * The enlarged part that contains a point. It is unchanged while the point is well inside, so that the cells do not
 * move with the noise of the reading; otherwise the point becomes right of the centre.
 */
export function lensFor(point: number, span: number, total: number, before: Lens | null): Lens {
  const start = (wanted: number): number => Math.min(Math.max(0, wanted), Math.max(0, total - span));
  if (before && Math.abs(before.span - span) < 1e-9) {
    const place = (point - before.start) / span;
    if (place >= 0.3 && place <= 0.8) return before;
    if (place >= 0 && place < 0.3 && before.start === 0) return before;
  }
  return { start: start(point - 0.6 * span), span };
}

/** Move the enlarged part as little as necessary to contain a dragged point. */
export function lensKeeping(point: number, lens: Lens): Lens {
  const margin = 0.08 * lens.span;
  if (point < lens.start + margin) return { start: Math.max(0, point - margin), span: lens.span };
  if (point > lens.start + lens.span - margin) return { start: point + margin - lens.span, span: lens.span };
  return lens;
}

const EXTENTS = [1.2, 2, 3.3, 5, 7.5];

/** The half-height of the evidence axis that shows `value` with room above it. */
export function extentFor(value: number): number {
  return EXTENTS.find((extent) => extent >= Math.abs(value) * 1.25) ?? EXTENTS[EXTENTS.length - 1] ?? 7.5;
}
