// @vitest-environment happy-dom
import { afterEach, describe, expect, it, vi } from "vitest";
import { cancel, upload, uploads } from "./uploading";

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
          this.status = [202, 429, 503][Math.max(0, refusals)] ?? 0;
          this.responseText = JSON.stringify(refusals > 0 ? { code: "busy", message: "Busy." } : {});
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

  it("are given up here and on the server", async () => {
    const forgotten: string[] = [];
    vi.stubGlobal("fetch", async (url: string, options?: RequestInit) => {
      if (options?.method === "DELETE") forgotten.push(url);
      return Response.json({ logs: [] });
    });
    const sent: string[] = [];
    class Request {
      status = 0;
      responseText = "";
      upload = { onprogress: null };
      onloadend = (): void => {};
      open(_: string, url: string): void {
        sent.push(new URL(url, "http://here").searchParams.get("upload") ?? "");
      }
      setRequestHeader(): void {}
      send(): void {}
      abort(): void {
        this.onloadend();
      }
    }
    vi.stubGlobal("XMLHttpRequest", Request);
    for (let i = 0; i < 4; i++) upload(new File(["x"], `run_${i}.mcap`));
    expect(sent.length).toBe(3);
    const [first, , , last] = uploads.value.map((upload) => upload.key);
    cancel(last as number); // it has not begun
    cancel(first as number);
    await vi.waitFor(() => expect(forgotten).toEqual([`/api/logs/uploads/${sent[0]}`]));
    expect(uploads.value.map((upload) => upload.name)).toEqual(["run_1.mcap", "run_2.mcap"]);
    expect(sent.length).toBe(3);
  });
});
