// @vitest-environment happy-dom
import { signal } from "@preact/signals";
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { Store } from "../../../store/store";
import type { Trajectory } from "../../../wire/protocol";
import type { Span } from "../contents/series";
import { type ScanSeriesState, useScanSeries, useUsed } from "./useScanSeries";

const asked: string[] = [];

beforeEach(() => {
  asked.length = 0;
  vi.stubGlobal("fetch", (address: string | URL | Request) => {
    asked.push(String(address));
    const series = { axis: "time", times: [0, 4], columns: [], gaps: [] };
    return Promise.resolve(new Response(JSON.stringify(series), { headers: { "Content-Type": "application/json" } }));
  });
});
afterEach(() => {
  render(null, document.body);
  vi.unstubAllGlobals();
});

const Shown = ({ scans }: { readonly scans: ScanSeriesState }) => {
  useUsed(scans);
  return <p>{scans.whole.value.join("–")}</p>;
};

const zoom = signal<Span | null>(null);
const store = new Store(() => true);

function Page({ views }: { readonly views: number }) {
  const scans = useScanSeries(store, "s", zoom);
  return Array.from({ length: views }, (_, n) => <Shown key={n} scans={scans} />);
}

const show = (views: number) => act(() => render(<Page views={views} />, document.body));

test("the numbers are asked for once for all views, only while there is one", async () => {
  await show(0);
  expect(asked).toEqual([]);
  await show(2);
  await vi.waitFor(() => expect(document.body.textContent).toBe("0–40–4"));
  expect(asked).toHaveLength(1);
  await show(0);
  await show(1);
  expect(asked).toHaveLength(1);
  await act(() => {
    zoom.value = [1, 2];
  });
  expect(asked).toHaveLength(2);
  expect(asked[1]).toContain("start=1&end=2");
});

test("the interval of a link stays until another trajectory is chosen", async () => {
  const along = (name: string): Trajectory => ({ name, frame: "odom" }) as Trajectory;
  zoom.value = [1, 2];
  await show(1);
  for (const [name, span] of [
    ["odom", [1, 2]],
    ["slam", null],
  ] as const) {
    await act(() => {
      store.trajectory.value = along(name);
    });
    expect(zoom.value).toEqual(span);
  }
});
