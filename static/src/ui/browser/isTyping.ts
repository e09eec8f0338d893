/** Whether text is written into the element that has the focus. */
export const isWriting = (target: EventTarget | null): boolean =>
  target instanceof Element &&
  target.closest("input:not([type=radio], [type=checkbox], [type=range]), select, textarea") !== null;

/** Whether a key such as the space bar is meant for the element that has the focus, and not for the page. */
export const isTyping = (target: EventTarget | null, ...roles: readonly string[]): boolean => {
  const all = ["slider", ...roles].map((role) => `[role=${role}]`);
  return (
    target instanceof Element && target.closest(`input, select, button, a, summary, textarea, ${all.join()}`) !== null
  );
};
