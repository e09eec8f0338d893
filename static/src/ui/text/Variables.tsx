interface VariablesProps {
  /** A sentence as plain text. */
  readonly text: string;
  /** Within a text element of an SVG, which has no HTML in it. */
  readonly inSvg?: boolean;
}

/**
 * A Latin letter by itself, as `p` and the letters of `p(z | x, m)`. Not one are the words "a", "A" and "I", letters
 * behind an apostrophe, and units behind a number or alone in brackets, as in `0.5 m` and `z (m)`.
 */
const VARIABLE = /(?<![\p{L}\d’']|\d[ \u00a0]|\s\((?=.\)))([b-zB-HJ-Z])(?![\p{L}\d’'])/u;

/** A sentence with its variables in italics, as in the text of the lecture. */
export function Variables({ text, inSvg = false }: VariablesProps) {
  const letter = (run: string, key: string) =>
    inSvg ? (
      <tspan key={key} font-style="italic">
        {run}
      </tspan>
    ) : (
      <i key={key}>{run}</i>
    );
  return <>{text.split(VARIABLE).map((run, i) => (i % 2 === 1 ? letter(run, `${i} ${run}`) : run))}</>;
}
