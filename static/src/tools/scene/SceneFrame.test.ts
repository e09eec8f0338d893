// @vitest-environment happy-dom
import { afterEach, expect, test, vi } from "vitest";
import { Store } from "../../store/store";

afterEach(() => {
  vi.restoreAllMocks();
  vi.resetModules(); // whether there is a graphics card is found once
});

test.each([
  ["ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device (Subzero)), SwiftShader driver)", "?darkMode&unsmoothed"],
  ["ANGLE (NVIDIA, NVIDIA GeForce RTX 3060)", "?darkMode"],
])("a 3D view that %s draws has the query %s", async (renderer, query) => {
  const gl = { getExtension: () => null, getParameter: () => renderer, RENDERER: 0 };
  vi.spyOn(HTMLCanvasElement.prototype, "getContext").mockReturnValue(gl as never);
  const { sceneAddress } = await import("./SceneFrame");
  const store = new Store(() => true);
  expect(sceneAddress("abc", store, true)).toBe(`/scenes/abc/plain/${store.page}/${query}`);
});
