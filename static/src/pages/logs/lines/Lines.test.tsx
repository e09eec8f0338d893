// @vitest-environment happy-dom
import { signal } from "@preact/signals";
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, test } from "vitest";
import { Store } from "../../../store/store";
import type { ContentsAnswer } from "../../../wire/http";
import { ContentsContext, type ContentsState } from "../contents/useContents";
import { Lines } from "./Lines";
import type { LinesState } from "./lines";

afterEach(() => render(null, document.body));

test.each([
  [0, false],
  [12_345, true],
])("%i lines that are not listed are named", (leftOut, isSaid) => {
  const state = signal<ContentsState>({ kind: "ready", contents: {} as ContentsAnswer });
  const nothing = (): void => undefined;
  const contents = { state, begin: nothing, cancel: nothing, again: nothing };
  const line = { seconds: 1, level: 20, text: "Ready", topic: "/rosout", name: "base" };
  const lines: LinesState = {
    lines: signal([line]),
    failure: signal(null),
    leftOut: signal(leftOut),
    least: signal(0),
    node: signal(""),
    text: signal(""),
    chosen: signal(null),
  };
  act(() =>
    render(
      <ContentsContext.Provider value={contents}>
        <Lines store={new Store(() => true)} lines={lines} />
      </ContentsContext.Provider>,
      document.body,
    ),
  );
  expect(document.body.textContent).toContain("Ready");
  expect(document.body.textContent.includes("12,345 more lines are left out")).toBe(isSaid);
});
