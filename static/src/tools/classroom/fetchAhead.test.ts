// @vitest-environment happy-dom
import { beforeEach, expect, test, vi } from "vitest";
import { fetchAhead } from "./fetchAhead";

const PAGE = `<!doctype html><script type="module" src="/assets/lab-1.js"></script>
<link rel="modulepreload" href="/assets/first-1.js"><link rel="stylesheet" href="/assets/lab-1.css"><link rel="icon" href="/assets/icon.svg">`;
const asked = vi.fn(async () => new Response(PAGE));
const fetched = () =>
  [...document.querySelectorAll("head > link[rel=prefetch]")].map((link) => link.getAttribute("href"));

beforeEach(() => {
  document.head.innerHTML = '<link rel="modulepreload" href="/assets/first-1.js">';
  vi.stubGlobal("fetch", asked);
});

test("the files of a page are fetched that this page does not have", async () => {
  await fetchAhead("/class/ABCDEF/lab.html");
  expect(asked).toHaveBeenCalledWith("/class/ABCDEF/lab.html", { priority: "low" });
  expect(fetched()).toEqual(["/assets/lab-1.js", "/assets/lab-1.css"]);
});

test("nothing is fetched of a page that is refused", async () => {
  asked.mockResolvedValueOnce(new Response("", { status: 403 }));
  await fetchAhead("/class/ABCDEF/lab.html");
  expect(fetched()).toEqual([]);
});
