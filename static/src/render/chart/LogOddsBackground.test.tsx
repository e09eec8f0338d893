// @vitest-environment happy-dom
import { h, render } from "preact";
import { afterEach, expect, test } from "vitest";
import { evidenceScale, readingScale, ZoneNames } from "./LogOddsBackground";

afterEach(() => render(null, document.body));

/** Greatest width of a character of the names, pixels. */
const CHARACTER = 7;

test.each([274, 600])("the names of the zones are right of every line in a chart of %d px", (width) => {
  const evidence = evidenceScale(240, [-2, 3.5], []);
  render(h("svg", null, h(ZoneNames, { width, evidence })), document.body);
  const names = [...document.querySelectorAll("text")];
  expect(names.map((name) => name.textContent)).toEqual(["occupied", "unknown", "free"]);
  const { to } = readingScale(width, 0, 25);
  for (const name of names)
    expect(Number(name.getAttribute("x")) - CHARACTER * (name.textContent?.length ?? 0)).toBeGreaterThanOrEqual(to);
});
