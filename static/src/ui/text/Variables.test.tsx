// @vitest-environment happy-dom
import { render } from "preact";
import { expect, test } from "vitest";
import { Variables } from "./Variables";

function italics(text: string): string[] {
  const place = document.createElement("p");
  render(<Variables text={text} />, place);
  expect(place.textContent).toBe(text);
  return [...place.querySelectorAll("i")].map((letter) => letter.textContent ?? "");
}

test.each([
  ["Each hit alone gives p = 0.75. After how many is p exactly 1?", ["p", "p"]],
  ["Why can’t we get the inverse model from p(z | x, m) alone?", ["p", "z", "x", "m"]],
  ["reading z (m), p(m)", ["z", "p", "m"]],
  ["the square root of e, of p/n", ["e", "p", "n"]],
])("the variables of “%s” are in italics", (text, letters) => {
  expect(italics(text)).toEqual(letters);
});

test.each([
  "A robot is raised from 3 m to 5\u00a0m in 2 s, by 0.4 m².",
  "The robot’s map, and I don't know a 3D one. A* and 2D.",
  "ℓ is clamped between −2.0 and +3.5.",
])("“%s” has none", (text) => {
  expect(italics(text)).toEqual([]);
});
