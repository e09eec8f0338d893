// @vitest-environment happy-dom
import { signal } from "@preact/signals";
import { render } from "preact";
import { act } from "preact/test-utils";
import { expect, it } from "vitest";
import { INITIAL_PARAMETERS } from "../../grid/sensorModel";
import { ProfileFigure } from "./Profile";
import { ProfileView } from "./view";

it("says beside its title that it can be dragged, until it was", async () => {
  const view = new ProfileView(signal({ ...INITIAL_PARAMETERS }), signal(4));
  const place = document.createElement("div");
  await act(() =>
    render(<ProfileFigure view={view} setParameter={() => undefined} where="straight ahead" fits />, place),
  );
  expect(place.querySelector("h2")?.textContent).toBe("The sensor model");
  expect(place.querySelector(".profile-hint")?.textContent).toContain("Drag");
  await act(() => {
    view.held.value = "hit";
  });
  await act(() => {
    view.held.value = null;
  });
  expect(place.querySelector(".profile-hint")).toBeNull();
  render(null, place);
  view.dispose();
});
