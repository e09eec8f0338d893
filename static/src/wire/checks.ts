/** Checks of JSON values, used by the generated validators in `messages.ts`. */

export type Check = (value: unknown) => boolean;

export const isNumber: Check = (value) => typeof value === "number" && Number.isFinite(value);
export const isPositive: Check = (value) => isNumber(value) && (value as number) > 0;
export const isInteger: Check = (value) => Number.isInteger(value);
export const isText: Check = (value) => typeof value === "string";
export const isFlag: Check = (value) => typeof value === "boolean";
export const isNull: Check = (value) => value === null;
const isPlainObject: Check = (value) => typeof value === "object" && value !== null && !Array.isArray(value);

export const isLiteral = (...values: readonly unknown[]): Check => {
  return (value) => values.includes(value);
};

export const oneOf = (...checks: readonly Check[]): Check => {
  return (value) => checks.some((check) => check(value));
};

export const optional = (check: Check): Check => {
  return (value) => value === undefined || check(value);
};

export const isListOf = (check: Check): Check => {
  return (value) => Array.isArray(value) && value.every(check);
};

export const isTuple = (...checks: readonly Check[]): Check => {
  return (value) =>
    Array.isArray(value) && value.length === checks.length && checks.every((check, i) => check(value[i]));
};

export const isRecordOf = (check: Check): Check => {
  return (value) => isPlainObject(value) && Object.values(value as object).every(check);
};

/** An object with at least these fields. */
export const isObject = (fields: Readonly<Record<string, Check>>): Check => {
  return (value) =>
    isPlainObject(value) &&
    Object.entries(fields).every(([name, check]) => check((value as Record<string, unknown>)[name]));
};
