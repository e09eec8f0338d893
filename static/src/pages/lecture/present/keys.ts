/**
 * The keys of the presentation. PageUp and PageDown, which clickers send, always turn the page. So do the arrow keys
 * and the space bar, unless the focused element needs them: a text field, or a control focused by Tab or by touch. A
 * control that was only clicked with the mouse leaves them to the slides.
 */

import { signal } from "@preact/signals";

export type Act = "next" | "back" | "nextSlide" | "previousSlide" | "first" | "last" | "blank" | "exit" | "release";

/** The kind of the focused element with respect to keys. */
export interface Focused {
  /** Text input. */
  readonly isText: boolean;
  /** Arrow keys change it: a slider, a handle, a menu. */
  readonly usesArrows: boolean;
  /** The space bar presses it. */
  readonly usesSpace: boolean;
  /** How it was focused. */
  readonly by: "mouse" | "touch" | "tab" | null;
}

const PAGES: Record<string, Act> = { PageDown: "next", PageUp: "back" };
const ARROWS: Record<string, Act> = { ArrowRight: "next", ArrowDown: "next", ArrowLeft: "back", ArrowUp: "back" };
const WHOLE: Partial<Record<Act, Act>> = { next: "nextSlide", back: "previousSlide" };

/** The action of a key; null leaves the key to the page. */
export function actOf(key: string, shift: boolean, focused: Focused): Act | null {
  const own = focused.by === "tab" || focused.by === "touch";
  const whole = (act: Act): Act => (shift && WHOLE[act]) || act;
  const page = PAGES[key];
  if (page) return whole(page);
  if (key === "Escape") return (own && focused.usesArrows) || focused.isText ? "release" : "exit";
  if (focused.isText) return null;
  const arrow = ARROWS[key];
  if (arrow) return own && focused.usesArrows ? null : whole(arrow);
  if (key === " ") return own && focused.usesSpace ? null : shift ? "back" : "next";
  if (own && focused.usesArrows && (key === "Home" || key === "End")) return null;
  if (key === "Home") return "first";
  if (key === "End") return "last";
  if (key === "b" || key === "B" || key === ".") return "blank";
  return null;
}

const TEXT =
  "input:not([type=range], [type=checkbox], [type=radio], [type=button], [type=file]), textarea, [contenteditable]";
const ARROW = "[role=slider], input[type=range], input[type=radio], select, [role=tab], [role=application]";
const SPACE = "button, summary, select, input[type=checkbox], input[type=radio], [role=button], a[href]";

let pointer: Focused["by"] = null;

/** The name of the control that receives the arrow keys; null if the slides do. */
export const arrowsGoTo = signal<string | null>(null);

let by: Focused["by"] = null;

function focusedOf(element: Element | null): Focused {
  return {
    isText: element?.matches(TEXT) ?? false,
    usesArrows: element?.matches(ARROW) ?? false,
    usesSpace: element?.matches(SPACE) ?? false,
    by,
  };
}

function nameOf(element: Element): string {
  const label = element.getAttribute("aria-label") ?? (element as HTMLInputElement).labels?.[0]?.textContent;
  return label?.trim() || "the control";
}

function noteFocus(element: Element | null): void {
  const focused = focusedOf(element);
  const takes = element !== null && focused.usesArrows && (by === "tab" || by === "touch");
  arrowsGoTo.value = takes ? nameOf(element) : null;
}

/** Listen to a window: this page's, or that of a page inside a slide. The returned function stops it. */
export function listenToKeys(target: Window, act: (act: Act) => void, isOn: () => boolean): () => void {
  const stop = new AbortController();
  const options = { capture: true, signal: stop.signal };
  const { document } = target;
  target.addEventListener(
    "keydown",
    (event) => {
      if (event.key === "Tab") pointer = "tab";
      if (!isOn() || event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
      const focused = focusedOf(document.activeElement);
      const action = actOf(event.key, event.shiftKey, focused);
      if (!action) return;
      event.preventDefault();
      event.stopImmediatePropagation();
      if (action === "release") (document.activeElement as HTMLElement | null)?.blur();
      else act(action);
    },
    options,
  );
  target.addEventListener(
    "pointerdown",
    (event) => {
      pointer = event.pointerType === "touch" || event.pointerType === "pen" ? "touch" : "mouse";
      // It may already have the focus.
      if (document.activeElement?.contains(event.target as Node)) {
        by = pointer;
        noteFocus(document.activeElement);
      }
    },
    options,
  );
  target.addEventListener(
    "focusin",
    (event) => {
      by = pointer;
      noteFocus(event.target as Element);
    },
    options,
  );
  target.addEventListener(
    "focusout",
    () => {
      by = null;
      arrowsGoTo.value = null;
    },
    options,
  );
  return () => stop.abort();
}
