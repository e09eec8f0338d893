/** Formulas in the text of own slides: a line between two dollar signs, with indices and exponents as in LaTeX. */

export interface FormulaPart {
  readonly text: string;
  readonly place: "line" | "sub" | "sup";
}

const PART = /([_^])(?:\{([^{}]*)\}|(\S))|([^_^]+|[_^])/gu;

/** The formula of a line such as `$p_t = 1 - e^{-x}$`; null where the line is none. */
export function formulaOf(line: string): readonly FormulaPart[] | null {
  const inside = /^\s*\$(.+)\$\s*$/u.exec(line)?.[1];
  if (!inside) return null;
  return [...inside.matchAll(PART)].map(([, mark, braced, single, plain]) =>
    mark
      ? { text: (braced ?? single ?? "").replaceAll("-", "−"), place: mark === "_" ? "sub" : "sup" }
      : { text: (plain ?? "").replaceAll("-", "−"), place: "line" },
  );
}
