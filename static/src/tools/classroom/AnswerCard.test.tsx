// @vitest-environment happy-dom
import { signal } from "@preact/signals";
import { h, render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, test } from "vitest";
import type { Classroom } from "../../store/classroom";
import type { ClassQuestion } from "../../wire/protocol";
import { AnswerCard } from "./FollowerBar";

const GUESS: ClassQuestion = {
  id: 1,
  text: "How probable is it?",
  options: null,
  axis: { low: 0, high: 1, unit: "" },
  is_revealed: false,
  is_closed: false,
  answered: 0,
  counts: null,
  right: null,
};

afterEach(() => render(null, document.body));

/** Show a question to a follower who has given an answer or none. */
function shown(question: ClassQuestion, given: number | null, isConnected = true): HTMLElement {
  const room = {
    state: signal({ question }),
    answer: signal(given === null ? null : { question: question.id, value: given }),
    isConnected: signal(isConnected),
    welcome: signal({ number: 4 }),
  };
  act(() => render(h(AnswerCard, { room: room as unknown as Classroom }), document.body));
  return document.body;
}

const status = (card: HTMLElement): string => card.querySelector("[role=status]")?.textContent ?? "";

test("a guess begins in the middle of its axis, also of a short one", () => {
  expect(shown(GUESS, null).querySelector("input")?.value).toBe("0.5");
});

test("the error of a guess has no rounding errors", () => {
  const revealed = { ...GUESS, is_revealed: true, is_closed: true, answered: 1, counts: [1], right: 0.3 };
  expect(status(shown(revealed, 0.35))).toBe("1 answered. The result is 0.3. Yours was 0.05 too high.");
});

test("the verdict on an answer names the right one", () => {
  const asked = { ...GUESS, axis: null, options: ["The first", "The ninth"], is_revealed: true, is_closed: true };
  const revealed = { ...asked, answered: 2, counts: [1, 1], right: 1 };
  expect(status(shown(revealed, 0))).toBe("2 answered. A is wrong; the answer is B: The ninth");
  expect(status(shown(revealed, 1))).toBe("2 answered. B is right.");
  expect(status(shown(revealed, null))).toBe("2 answered. The answer is B: The ninth");
  expect(status(shown({ ...revealed, right: null }, 0)).trim()).toBe("2 answered.");
  const guessed = { ...GUESS, is_revealed: true, is_closed: true, answered: 1, counts: [1], right: 0.3 };
  expect(status(shown(guessed, null))).toBe("1 answered. The result is 0.3.");
});

test("who joined after the question is told where such answers are not counted", () => {
  const question = { ...GUESS, axis: null, options: ["Yes", "No"] };
  expect(status(shown(question, null))).toBe("Tap your answer. It is counted without your name.");
  expect(status(shown({ ...question, last_number: 4 }, null))).toContain("Tap your answer.");
  expect(status(shown({ ...question, last_number: 3 }, 1))).toContain("your answer is not counted");
});

test("an answer that could not be sent yet is not called answered", () => {
  const question = { ...GUESS, axis: null, options: ["Yes", "No"] };
  expect(status(shown(question, 1))).toContain("Answered.");
  expect(status(shown(question, 1, false))).toContain("as soon as the class can be reached");
});
