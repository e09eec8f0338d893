/** A message as YAML, as `ros2 topic echo` prints it. */

export type Tree = string | number | boolean | null | readonly Tree[] | { readonly [name: string]: Tree };

/** Whether a value has parts of its own. */
export const isBranch = (value: Tree): value is readonly Tree[] | { readonly [name: string]: Tree } =>
  typeof value === "object" && value !== null;

/** The parts of a branch, with the names of fields or the numbers of elements. */
export const partsOf = (value: readonly Tree[] | { readonly [name: string]: Tree }): readonly [string, Tree][] =>
  Array.isArray(value)
    ? value.map((one: Tree, n): [string, Tree] => [String(n), one])
    : Object.entries(value as { readonly [name: string]: Tree });

/** Texts that stand as they are: numbers that JSON has not. */
const PLAIN = /^(\.nan|-?\.inf|-?\d{16,20})$/;

/** A value without parts, as YAML writes it. */
export function scalar(value: Tree): string {
  if (typeof value !== "string") return Array.isArray(value) ? "[]" : isBranch(value) ? "{}" : String(value);
  if (PLAIN.test(value)) return value;
  return JSON.stringify(value); // a text in JSON's quotes is one of YAML's, too
}

/** The lines of a message; a part of a sequence begins with a dash. */
export function yamlOf(value: Tree, indent = ""): string {
  if (!isBranch(value) || partsOf(value).length === 0) return `${indent}${scalar(value)}\n`;
  const isList = Array.isArray(value);
  return partsOf(value)
    .map(([name, part]) => {
      const isNested = isBranch(part) && partsOf(part).length > 0;
      if (!isList)
        return isNested ? `${indent}${name}:\n${yamlOf(part, `${indent}  `)}` : `${indent}${name}: ${scalar(part)}\n`;
      return isNested
        ? `${indent}- ${yamlOf(part, `${indent}  `).slice(indent.length + 2)}`
        : `${indent}- ${scalar(part)}\n`;
    })
    .join("");
}
