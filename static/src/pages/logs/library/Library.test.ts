import { describe, expect, it } from "vitest";
import { uploadText } from "./Library";
import type { Upload } from "./uploading";

// @vitest-environment happy-dom

const upload = (sent: number, since: Upload["since"]): Upload => ({
  key: 1,
  name: "run.mcap",
  bytes: 2_000_000_000,
  sent,
  error: null,
  since,
});

describe("how far an upload is", () => {
  it("waits before it is sent", () => {
    expect(uploadText(upload(0, null), 0)).toMatch(/^waiting, /);
  });

  it("states the share at once, the rate and the time left when they were measured", () => {
    expect(uploadText(upload(500_000_000, { at: 0, sent: 0 }), 1000)).toMatch(/, 25 %$/);
    const text = uploadText(upload(500_000_000, { at: 0, sent: 0 }), 10_000);
    expect(text).toMatch(/, 25 %, .*\/s, 0:30 left$/);
  });

  it("measures the rate of the present connection only", () => {
    const text = uploadText(upload(1_500_000_000, { at: 1000, sent: 1_000_000_000 }), 6000);
    expect(text).toMatch(/, 75 %, .*\/s, 0:05 left$/);
  });

  it("says that the server has yet to store what was sent", () => {
    expect(uploadText(upload(2_000_000_000, { at: 0, sent: 0 }), 10_000)).toContain("the server stores them");
  });
});
