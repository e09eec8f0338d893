// @vitest-environment happy-dom
import { signal } from "@preact/signals";
import { h, render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, test } from "vitest";
import type { Classroom } from "../../store/classroom";
import { FollowerBar } from "./FollowerBar";
import { loadingPage } from "./pages";

afterEach(() => {
  render(null, document.body);
  loadingPage.value = null;
});

/** Show the line of a follower below the view that the lecturer controls; returns the view and a second place. */
function shown(drives: boolean, isLecturerAway = false, page = "lab"): readonly HTMLElement[] {
  const room = {
    state: signal({ question: null, present: 1, puzzle: null, is_lecturer_away: isLecturerAway }),
    welcome: signal({ number: 1 }),
    shown: signal({ stage: 1, view: { page } }),
    own: signal(null),
    isConnected: signal(true),
    isOutdated: signal(false),
    isOver: signal(false),
    refused: signal(null),
    asksForRobot: signal(false),
    drives: signal(drives),
  };
  const content = h("div", {}, [
    h("main", { class: "is-following" }),
    h("header", {}),
    h(FollowerBar, { room: room as unknown as Classroom }),
  ]);
  act(() => render(content, document.body));
  return [...document.querySelectorAll<HTMLElement>("main, header")];
}

const status = (): string => document.querySelector("[role=status]")?.textContent ?? "";

test("a follower who clicks what the lecturer controls is told of the copy", () => {
  const [view, elsewhere] = shown(false);
  expect(status()).toContain("Following the lecturer.");
  act(() => view?.click());
  expect(status()).toContain("“Try it yourself” gives you a copy.");
  act(() => elsewhere?.click());
  expect(status()).toContain("Following the lecturer.");
});

test("a follower reads that the lecturer is away", () => {
  shown(false, true);
  expect(status()).toContain("The lecturer is away.");
  expect(status()).not.toContain("Following");
});

test("a follower reads that the page is loaded which the lecturer has opened", () => {
  shown(false);
  act(() => {
    loadingPage.value = "lab";
  });
  expect(status()).toContain("Loading the page that the lecturer has opened …");
  expect(status()).not.toContain("Following");
});

test("a follower does not read that a page is followed which cannot be", () => {
  shown(false, false, "other");
  expect(status()).toContain("Waiting for the lecturer.");
  expect(status()).not.toContain("Following");
});

test("who drives the robot is not told so", () => {
  const [view] = shown(true);
  act(() => view?.click());
  expect(status()).toContain("You drive the robot");
});
