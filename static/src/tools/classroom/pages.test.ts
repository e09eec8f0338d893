import { signal } from "@preact/signals";
import { expect, test, vi } from "vitest";
import type { ClassView } from "../../wire/protocol";

const shown = signal<{ view: ClassView } | null>(null);
const isFollowing = signal(true);

vi.mock("../../store/classroom", () => ({
  followedCode: "ABCDEF",
  classroom: signal({ code: "ABCDEF", shown, isFollowing }),
}));

const { followPages, loadingPage } = await import("./pages");

test("a follower's page goes once to each page that the lecturer shows", () => {
  const gone: string[] = [];
  vi.stubGlobal("location", { replace: (address: string) => gone.push(address) });
  const show = (page: ClassView["page"], hash = "") => {
    shown.value = { view: { page, hash, blank: false } };
  };
  followPages("lecture");
  show("lecture", "#odometry");
  expect(gone).toEqual([]);
  expect(loadingPage.value).toBeNull();
  show("logs");
  show("logs", "#a"); // before the browser has left this page
  show("logs", "#b");
  expect(gone).toEqual(["/class/ABCDEF/logs.html"]);
  expect(loadingPage.value).toBe("logs");
  show("lab");
  show("lecture");
  expect(gone.slice(1)).toEqual(["/class/ABCDEF/lab.html", "/class/ABCDEF/lecture.html"]);
  isFollowing.value = false;
  show("lab");
  expect(gone).toHaveLength(3);
  isFollowing.value = true;
  expect(gone[3]).toBe("/class/ABCDEF/lab.html");
});
