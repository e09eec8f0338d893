import { describe, expect, it } from "vitest";
import { mayBeLogs } from "./library";

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
