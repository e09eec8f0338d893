// @vitest-environment happy-dom
import { signal } from "@preact/signals";
import { h, render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, test } from "vitest";
import { openClass } from "../../store/classroom";
import { CodeDialog } from "./CodeDialog";

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
