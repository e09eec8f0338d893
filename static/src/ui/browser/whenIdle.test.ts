// @vitest-environment happy-dom
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { whenIdle } from "./whenIdle";

describe("whenLeftAlone", () => {
  beforeEach(() => void vi.useFakeTimers());
  afterEach(() => void vi.useRealTimers());

  it("waits until there was no press, drag or key for a while", () => {
    const task = vi.fn();
    whenIdle(1000, task);
    for (const sign of ["keydown", "pointerdown", "wheel"]) {
      vi.advanceTimersByTime(900);
      dispatchEvent(new Event(sign));
    }
    vi.advanceTimersByTime(900);
    dispatchEvent(new PointerEvent("pointermove", { buttons: 1 }));
    vi.advanceTimersByTime(999);
    expect(task).not.toHaveBeenCalled();
    vi.advanceTimersByTime(1);
    expect(task).toHaveBeenCalledTimes(1);
    dispatchEvent(new Event("keydown"));
    vi.advanceTimersByTime(5000);
    expect(task).toHaveBeenCalledTimes(1);
  });

  it("is not kept waiting by a pointer that only passes", () => {
    const task = vi.fn();
    whenIdle(1000, task);
    vi.advanceTimersByTime(900);
    dispatchEvent(new PointerEvent("pointermove", { buttons: 0 }));
    vi.advanceTimersByTime(100);
    expect(task).toHaveBeenCalledTimes(1);
  });

  it("waits while the page is hidden", () => {
    const task = vi.fn();
    const hidden = vi.spyOn(document, "hidden", "get").mockReturnValue(true);
    whenIdle(1000, task);
    vi.advanceTimersByTime(5000);
    expect(task).not.toHaveBeenCalled();
    hidden.mockReturnValue(false);
    document.dispatchEvent(new Event("visibilitychange"));
    vi.advanceTimersByTime(1000);
    expect(task).toHaveBeenCalledTimes(1);
    hidden.mockRestore();
  });

  it("can be called off", () => {
    const task = vi.fn();
    whenIdle(1000, task)();
    vi.advanceTimersByTime(5000);
    expect(task).not.toHaveBeenCalled();
  });
});
