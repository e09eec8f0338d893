import { afterEach, describe, expect, it, vi } from "vitest";
import { mayBeLogs, upload, uploads } from "./library";

const chosen = (...names: string[]): string[] =>
  mayBeLogs(names.map((name) => new File(["x"], name))).map((file) => file.name);

describe("files that are chosen together", () => {
  it("are taken without what lies beside recordings", () => {
    expect(chosen("metadata.yaml", "run_0.db3", "run_0.db3-wal", "run_0.db3-shm", "run_1.db3", ".DS_Store")).toEqual([
      "run_0.db3",
      "run_1.db3",
    ]);
    expect(chosen("a.mcap", "b.bag.gz", "notes")).toEqual(["a.mcap", "b.bag.gz", "notes"]);
  });

  it("a single one is taken whatever it is called: the server says what it is", () => {
    expect(chosen("run_0.db3-wal")).toEqual(["run_0.db3-wal"]);
  });
});

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
