/** What a control needs so that it shows the value of a signal and sets it. */

import type { Signal } from "@preact/signals";

/** For a slider. */
export const bound = (signal: Signal<number>) => ({
  value: signal.value,
  onInput: (value: number): void => {
    signal.value = value;
  },
});

/** For a choice or a menu. */
export const selected = <V extends string>(signal: Signal<V>) => ({
  value: signal.value,
  onChange: (value: V): void => {
    signal.value = value;
  },
});

/** For a switch. */
export const switched = (signal: Signal<boolean>) => ({
  checked: signal.value,
  onChange: (checked: boolean): void => {
    signal.value = checked;
  },
});
