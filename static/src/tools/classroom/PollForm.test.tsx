// @vitest-environment happy-dom
import { signal } from "@preact/signals";
import { h, render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, test, vi } from "vitest";
import type { Classroom } from "../../store/classroom";
import { PollForm } from "./LecturerBar";

afterEach(() => render(null, document.body));

/** Open the form of a class; returns what it sends. */
function opened(isConnected = true) {
  const room = { send: vi.fn(), isConnected: signal(isConnected) };
  act(() => render(h(PollForm, { room: room as unknown as Classroom, isOpen: signal(true) }), document.body));
  type("Question", "Is it free?");
  return room.send;
}

const label = (text: string): HTMLLabelElement | undefined =>
  [...document.querySelectorAll("label")].find((label) => label.textContent?.includes(text));

function type(field: string, text: string): void {
  const input = label(field)?.querySelector("input");
  if (!input) throw new Error(`no field ${field}`);
  act(() => {
    input.value = text;
    input.dispatchEvent(new Event("input", { bubbles: true }));
  });
}

function button(name: string): HTMLButtonElement {
  const found = [...document.querySelectorAll("button")].find(
    (button) => button.getAttribute("aria-label") === name || button.textContent === name,
  );
  if (!found) throw new Error(`no button ${name}`);
  return found;
}

function press(name: string): void {
  act(() => button(name).click());
}

test("a question has the right option among those that are not empty", () => {
  const sent = opened();
  press("Another option");
  type("Option C", "Perhaps");
  type("Option A", " ");
  press("Mark C as right");
  press("Ask");
  expect(sent).toHaveBeenCalledWith({ type: "ask", text: "Is it free?", options: ["No", "Perhaps"], right: 1 });
});

test("a mark is taken away by a second press, and no right option is sent", () => {
  const sent = opened();
  press("Mark B as right");
  press("Mark B as right");
  press("Ask");
  expect(sent).toHaveBeenCalledWith({ type: "ask", text: "Is it free?", options: ["Yes", "No"] });
});

test("a number is asked with its axis and the right one, written with a point or a comma", () => {
  const sent = opened();
  const choice = label("A number")?.querySelector("input");
  act(() => choice?.click());
  type("From", "0,5");
  type("To", "2");
  type("Right", "word");
  expect(button("Ask").disabled).toBe(true);
  type("Right", "1.25");
  press("Ask");
  const axis = { low: 0.5, high: 2, unit: "" };
  expect(sent).toHaveBeenCalledWith({ type: "ask", text: "Is it free?", axis, right: 1.25 });
});

test("nothing is asked without a connection", () => {
  opened(false);
  expect(button("Ask").disabled).toBe(true);
  expect(document.querySelector("[role=status]")?.textContent).toContain("cannot be reached");
});
