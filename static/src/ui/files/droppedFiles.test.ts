import { describe, expect, it } from "vitest";
import { filesIn } from "./droppedFiles";

const file = (name: string): FileSystemEntry =>
  ({
    name,
    isDirectory: false,
    file: (done: (file: File) => void) => done(new File(["x"], name)),
  }) as unknown as FileSystemEntry;

/** A folder that gives its entries two at a time, as browsers give a hundred. */
const folder = (name: string, entries: readonly FileSystemEntry[]): FileSystemEntry =>
  ({
    name,
    isDirectory: true,
    createReader: () => {
      let at = 0;
      return {
        readEntries: (done: (part: FileSystemEntry[]) => void) => {
          at += 2;
          done(entries.slice(at - 2, at));
        },
      };
    },
  }) as unknown as FileSystemEntry;

const names = async (entries: readonly FileSystemEntry[]) =>
  (await filesIn(entries)).map((group) => [group.name, ...group.files.map((file) => file.name)]);

describe("what is dropped", () => {
  it("has the files of its folders, by name, with numbers as numbers", async () => {
    const run = folder("run", [
      file("run_10.db3"),
      file("run_2.db3"),
      file("metadata.yaml"),
      folder("old", [file("a")]),
    ]);
    expect(await names([file("first"), run, file("last")])).toEqual([
      ["", "first", "last"],
      ["run", "metadata.yaml", "run_2.db3", "run_10.db3"],
      ["old", "a"],
    ]);
  });

  it("leaves out what cannot be read, and ends", async () => {
    const broken = {
      name: "b",
      isDirectory: false,
      file: (_: unknown, fail: (why: Error) => void) => fail(new Error()),
    };
    expect(await names([broken as unknown as FileSystemEntry, file("a")])).toEqual([["", "a"]]);
    const many = folder(
      "many",
      Array.from({ length: 2000 }, (_, i) => file(String(i))),
    );
    expect((await filesIn([many]))[0]?.files.length).toBe(500);
  });
});
