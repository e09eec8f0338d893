/** Signals whose values this browser keeps. */

import { effect, type Signal, signal } from "@preact/signals";

/** A signal that begins with what the browser has kept under `key`, if `isValid`, and keeps what it is set to. */
export function kept<T>(key: string, first: T, isValid: (value: unknown) => value is T): Signal<T> {
  const value = signal<T>(read(key, first, isValid));
  let before = value.peek();
  effect(() => {
    const now = value.value;
    if (now === before) return;
    before = now;
    try {
      localStorage.setItem(key, JSON.stringify(now));
    } catch {
      // storage may be forbidden or full; the page works without it
    }
  });
  return value;
}

function read<T>(key: string, first: T, isValid: (value: unknown) => value is T): T {
  try {
    const stored: unknown = JSON.parse(localStorage.getItem(key) ?? "null");
    return isValid(stored) ? stored : first;
  } catch {
    return first;
  }
}

/** Whether it is a number from `low` to `high`. */
export const isWithin =
  (low: number, high: number) =>
  (value: unknown): value is number =>
    typeof value === "number" && value >= low && value <= high;

export const isBoolean = (value: unknown): value is boolean => typeof value === "boolean";
