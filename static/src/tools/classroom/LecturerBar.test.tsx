import { computed, signal } from "@preact/signals";
import { h, render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, test, vi } from "vitest";
import { type Classroom, openClass, questionInHeading } from "../../store/classroom";
import { CodeDialog, LecturerBar } from "./LecturerBar";

// @vitest-environment happy-dom

afterEach(() => {
  render(null, document.body);
  questionInHeading.value = null;
});

const QUESTION = {
  id: 1,
  text: "Is it free?",
  options: ["Yes", "No"],
  axis: null,
  is_revealed: false,
  is_closed: false,
  answered: 3,
};

/** The line of a lecturer whose class is asked a question, with a page that shows its answers or not. */
function shown(): { readonly send: ReturnType<typeof vi.fn> } {
  const lookedAt = signal<number | null>(null);
  const send = vi.fn();
  const room = {
    code: "BCDFGH",
    state: signal({ present: 4, is_locked: false, hands: [], driver: null, puzzle: null, question: QUESTION }),
    question: computed(() => ({ ...QUESTION, counts: lookedAt.value === 1 ? [1, 2] : null, right: null })),
    lookedAt,
    isConnected: signal(true),
    isOutdated: signal(false),
    isOver: signal(false),
    refused: signal(null),
    send,
  };
  act(() => render(h(LecturerBar, { room: room as unknown as Classroom }), document.body));
  return { send };
}

const listed = (): string => document.querySelector(".class-bars")?.textContent ?? "";
const press = (text: string): void => {
  const button = [...document.querySelectorAll("button")].find((button) => button.textContent === text);
  if (!button) throw new Error(`no button ${text}`);
  act(() => button.click());
};

test("before the reveal the options and how many have answered are shown, the answers when the lecturer asks", () => {
  const { send } = shown();
  expect(document.body.textContent).toContain("3 of 4 answered");
  expect(listed()).toBe("A YesB No");
  press("Show answers");
  expect(listed()).toBe("A Yes1B No2");
  press("Hide answers");
  expect(listed()).toBe("A YesB No");
  expect(send).not.toHaveBeenCalled();
  press("Show the result");
  expect(send).toHaveBeenCalledWith({ type: "reveal" });
});

test("below a slide that has the question as its heading it is not repeated", () => {
  questionInHeading.value = QUESTION.text;
  shown();
  expect(document.querySelector("h2")?.className).toBe("visually-hidden");
  expect(document.querySelector(".class-bars")).toBeNull();
  press("Show answers");
  expect(listed()).toBe("A Yes1B No2");
});

// @vitest-environment happy-dom

afterEach(() => {
  render(null, document.body);
  openClass.value = null;
});

test.each([
  ["http://127.0.0.1:8000", true],
  ["http://localhost:8000", true],
  ["http://[::1]:8000", true],
  ["http://192.168.1.7:8000", false],
  ["https://maps.example.org", false],
])("the code of a class at %s says whether other devices cannot open it: %s", (origin, isSaid) => {
  openClass.value = {
    present: 1,
    page: "lab",
    code: "BCDFGH",
    address: `${origin}/class/BCDFGH`,
    qr: "/qr.svg",
    results: "/results.csv",
  };
  act(() => render(h(CodeDialog, { isOpen: signal(true) }), document.body));
  expect(document.body.textContent?.includes("Only this computer reaches this address.")).toBe(isSaid);
});
