import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { describe, expect, it } from "vitest";
import { groupIntoLogs, tarred } from "./groupFiles";

const file = (name: string, text = name): File => new File([text], name);
const names = (folder: string, ...files: string[]): string[] =>
  groupIntoLogs({ name: folder, files: files.map((name) => file(name)) }).map((log) => log.name);

describe("files that are chosen together", () => {
  it("are logs each by itself, but for what lies beside them", () => {
    expect(names("", "run_0.db3", "run_0.db3-shm", "b.db3", ".DS_Store", "README.md")).toEqual(["run_0.db3", "b.db3"]);
    expect(names("", "a.mcap", "b.bag.gz", "notes")).toEqual(["a.mcap", "b.bag.gz", "notes"]);
    expect(names("run", "metadata.yaml", "run_0.db3")).toEqual(["run_0.db3"]);
  });

  it("are one log where a recorder that was killed left a journal beside the database", async () => {
    const [first, second] = ["a_0.db3", "a_1.db3"].map((name) => file(name));
    if (!first || !second) throw new Error("two parts");
    const journal = file("a_1.db3-wal", "rows");
    const beside = [file("a_0.db3-wal", ""), file("a_1.db3-shm")]; // an empty journal holds nothing
    const alone = groupIntoLogs({ name: "", files: [second, journal, ...beside] });
    expect(alone.map(({ name }) => name)).toEqual(["a_1.db3"]);
    expect(await alone[0]?.text()).toBe(await tarred([second, journal], "a").text());
    const parts = groupIntoLogs({ name: "a", files: [first, second, journal, ...beside] });
    expect(parts.map(({ name }) => name)).toEqual(["a"]);
    expect(await parts[0]?.text()).toBe(await tarred([first, second, journal], "a").text());
  });

  it("are one log where they are depth images with poses", () => {
    expect(names("room", "a.depth.png", "a.pose.txt", "camera-intrinsics.txt", "a.color.png")).toEqual([
      "room",
      "a.color.png",
    ]);
    expect(names("", "a.depth.png", "a.pose.txt")).toEqual(["depth images"]);
  });

  it("are one log where ROS 2 split a recording", () => {
    expect(names("run", "metadata.yaml", "run_0.db3", "run_1.db3")).toEqual(["run"]);
    expect(names("", "metadata.yaml", "my.run_0.mcap.zstd", "my.run_1.mcap.zstd", "a.log")).toEqual([
      "my.run",
      "a.log",
    ]);
    expect(names("run", "metadata.yaml", "run_0.db3", "run_0.mcap")).toEqual(["run_0.db3", "run_0.mcap"]);
    expect(names("", "run_1.db3", "run_0.db3", "a.log")).toEqual(["run", "a.log"]);
    const begun = ["run_2024-01-31-23-58-05_0.bag", "run_2024-02-01-00-03-05_1.bag.active"];
    expect(names("", ...begun)).toEqual(["run_2024-01-31-23-58-05"]);
    const others = ["run_2024-01-31-23-58-05_0.bag", "run_2024-02-01-00-03-05_0.bag"];
    expect(names("", ...others)).toEqual(others);
    expect(names("", "run_1.bag", "run_2.bag")).toEqual(["run_1.bag", "run_2.bag"]);
    expect(names("", "a_0.db3", "b_1.db3")).toEqual(["a_0.db3", "b_1.db3"]);
  });

  it("are one log where they are a ring of sonars", () => {
    expect(names("sonar", "measurement.txt", "poses.txt", "readme.md")).toEqual(["sonar"]);
    expect(names("", "measurement.txt", "poses.txt")).toEqual(["sonars"]);
    expect(names("", "poses.txt", "a.log")).toEqual(["poses.txt", "a.log"]);
  });

  it("are one map where a yaml and its image come together", () => {
    expect(names("", "office.pgm", "office.yaml", "a.log")).toEqual(["office.yaml", "a.log"]);
    expect(names("m", "o.pgm", "o.yaml", "o_keepout.pgm", "o_keepout.yaml", "o.edits.json")).toEqual(["o.yaml"]);
    expect(names("m", "o.pgm", "o.yaml", "o_speed.pgm", "o_speed.yaml")).toEqual(["o.yaml"]);
    expect(names("", "a.yaml", "b.yaml", "a.pgm")).toEqual(["a.yaml", "b.yaml", "a.pgm"]);
  });

  it("a single one is taken whatever it is called: the server says what it is", () => {
    expect(names("", "run_0.db3-wal")).toEqual(["run_0.db3-wal"]);
  });
});

describe("an archive of them", () => {
  it("is unpacked by tar", async () => {
    const folder = mkdtempSync(join(tmpdir(), "tar-"));
    try {
      const texts = new Map([
        ["metadata.yaml", "a: 1\n"],
        ["empty", ""],
        ["Übung_10.db3", "x".repeat(1024)],
        [`${"n".repeat(120)}_2.mcap`, "y".repeat(513)],
      ]);
      const archive = tarred(
        [...texts].map(([name, text]) => file(name, text)),
        "run",
      );
      expect(archive.size % 512).toBe(0);
      writeFileSync(join(folder, "run.tar"), new Uint8Array(await archive.arrayBuffer()));
      execFileSync("tar", ["xf", "run.tar"], { cwd: folder });
      for (const [name, text] of texts) expect(readFileSync(join(folder, name.slice(-100)), "utf8")).toBe(text);
    } finally {
      rmSync(folder, { recursive: true });
    }
  });
});
