// @vitest-environment happy-dom
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, test } from "vitest";
import { Store } from "../../store/store";
import { MeasuringIn3d } from "./MapTools";
import { measuringOf } from "./measuring";

afterEach(() => render(null, document.body));

test("what is measured is said once, though several views state it", () => {
  const store = new Store(() => true);
  const show = (keys: readonly string[]): void => {
    act(() =>
      render(
        keys.map((key) => <MeasuringIn3d key={key} store={store} snaps />),
        document.body,
      ),
    );
  };
  const of = (selector: string): (string | null)[] =>
    [...document.querySelectorAll(selector)].map(({ textContent }) => textContent);
  act(() => measuringOf(store).take("distance"));
  show(["a", "b"]);
  act(() => measuringOf(store).add([0, 0, 1], 0));
  act(() => measuringOf(store).add([3, 0, 1], 0));
  const [text] = of(".measured .number");
  expect(text).toContain("3.00 m");
  expect(of(".measured .number")).toEqual([text, text]);
  expect(of("[role=status]")).toEqual([text]);
  show(["b"]); // the one that said it is gone
  expect(of("[role=status]")).toEqual([text]);
});
