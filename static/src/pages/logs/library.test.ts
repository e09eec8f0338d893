import { afterEach, describe, expect, it, vi } from "vitest";
import { upload, uploads } from "./library";

describe("many files", () => {
  afterEach(() => {
    vi.unstubAllGlobals();
    vi.useRealTimers();
  });

  it("are sent a few at a time, and again where the server is busy", async () => {
    vi.useFakeTimers();
    vi.stubGlobal("fetch", async (url: string) =>
      Response.json(url.includes("/uploads/") ? { offset: 0 } : { logs: [] }),
    );
    const open = new Set<string>();
    const taken: string[] = [];
    let most = 0;
    let refusals = 2;
    class Request {
      status = 0;
      responseText = "";
      upload = { onprogress: null };
      onloadend = (): void => {};
      #name = "";
      open(_: string, url: string): void {
        this.#name = new URL(url, "http://here").searchParams.get("name") ?? "";
      }
      setRequestHeader(): void {}
      send(): void {
        open.add(this.#name);
        most = Math.max(most, open.size);
        setTimeout(() => {
          open.delete(this.#name);
          this.status = refusals > 0 ? 503 : 202;
          this.responseText = refusals > 0 ? JSON.stringify({ code: "library.busy", message: "Busy." }) : "{}";
          if (refusals-- <= 0) taken.push(this.#name);
          this.onloadend();
        }, 10);
      }
    }
    vi.stubGlobal("XMLHttpRequest", Request);
    const names = Array.from({ length: 12 }, (_, i) => `run_${i}.mcap`);
    for (const name of names) upload(new File(["x"], name));
    await vi.advanceTimersByTimeAsync(20_000);
    expect([...taken].sort()).toEqual([...names].sort());
    expect(most).toBe(3);
    expect(uploads.value).toEqual([]);
  });
});
