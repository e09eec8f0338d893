/** Whether this device is used by touch. */
const isTouched = (): boolean => matchMedia("(pointer: coarse)").matches;

/** What a hint says on this device: "Click" is "Tap" where it is used by touch. */
export const inHand = (hint: string): string =>
  isTouched() ? hint.replace(/\bClick\b/g, "Tap").replace(/\bclick\b/g, "tap") : hint;
