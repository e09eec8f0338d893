/** The program's text: lines of mapper/mapping/textbook.py itself, taken from the file when the pages are built. */

import textbook from "../../../../mapper/mapping/textbook.py?raw";

/** What the figure shows, in the order in which one calls the other. */
export const SHOWN = ["update_per_beam", "evidence_of_beam", "evidence_along_beam", "update", "bayes_filter"] as const;
export type FunctionName = (typeof SHOWN)[number];

export interface SourceLine {
  readonly fn: FunctionName;
  /** Lines after the function's `def`. */
  readonly offset: number;
  readonly text: string;
}

/** A function's lines, from its `def` to its last, without its docstring. */
export function linesOf(fn: FunctionName, source: string = textbook): readonly SourceLine[] {
  const all = source.split("\n");
  const first = all.findIndex((line) => line.startsWith(`def ${fn}(`));
  if (first < 0) throw new Error(`mapper/mapping/textbook.py has no function ${fn}`);
  let end = first + 1;
  while (end < all.length && (all[end] === "" || /^[\s)]/.test(all[end] ?? ""))) end++;
  const lines: SourceLine[] = [];
  let inDocstring = false;
  for (let i = first; i < end; i++) {
    const text = all[i] ?? "";
    const quotes = text.split('"""').length - 1;
    if (quotes === 0 && !inDocstring) lines.push({ fn, offset: i - first, text });
    if (quotes === 1) inDocstring = !inDocstring;
  }
  while (lines.at(-1)?.text === "") lines.pop();
  return lines.filter((line, i) => line.text !== "" || lines[i - 1]?.text !== "");
}

export const PROGRAM: readonly (readonly SourceLine[])[] = SHOWN.map((fn) => linesOf(fn));

/** The first line of a function that begins with some text. */
export function lineOf(fn: FunctionName, beginning: string): number {
  const sourceLine = PROGRAM[SHOWN.indexOf(fn)]?.find((line) => line.text.trim().startsWith(beginning));
  if (!sourceLine) throw new Error(`${fn} of mapper/mapping/textbook.py has no line that begins with ${beginning}`);
  return sourceLine.offset;
}
