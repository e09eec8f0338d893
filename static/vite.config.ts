import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { defineConfig } from "vitest/config";
import { FIRST_PAINT, FIRST_PAINT_FILES, PREVIEW_TAGS } from "./firstPaint";

/** Where `npm run dev` finds the running service; `gridbloom serve` prints its address. */
const service = process.env.GRIDBLOOM_DEV_SERVER ?? "http://127.0.0.1:8000";

const page = (name: string): string => resolve(import.meta.dirname, name);

/** What the heads of all pages have in common, in place of the comment that names its file. */
const heads = {
  name: "heads",
  transformIndexHtml: {
    order: "pre" as const,
    handler: (html: string): string =>
      html.replace("    <!-- head.html -->\n", () => readFileSync(page("head.html"), "utf8")),
  },
};

/** The first picture in the front page's HTML. */
const firstPaint = {
  name: "first-paint",
  transformIndexHtml: {
    order: "post" as const,
    handler: (html: string): string =>
      html.includes("<!-- first paint -->")
        ? html
            .replace("<!-- first paint -->", () => FIRST_PAINT)
            .replace("<!-- preview -->", () => PREVIEW_TAGS)
            // The picture is there without the script: its style and fonts come first.
            .replace(/(<script type="module"|<link rel="modulepreload")/g, '$1 fetchpriority="low"')
        : html,
  },
  generateBundle(this: {
    emitFile: (file: { type: "asset"; fileName: string; source: string | Uint8Array }) => string;
  }) {
    for (const { path, content } of FIRST_PAINT_FILES)
      this.emitFile({ type: "asset", fileName: path, source: content });
  },
};

interface Modules {
  getModuleInfo(id: string): { readonly importedIds: readonly string[] } | null;
}

/** The modules that the script of the front page imports, directly or not; null until the first is asked for. */
let frontPage: Set<string> | null = null;

/** Whether the front page needs a module at its start: it loads only these, so that it can be used sooner. */
function isOnFrontPage(id: string, modules: Modules): boolean {
  if (!frontPage) {
    frontPage = new Set([page("src/pages/index.tsx")]);
    for (const one of frontPage)
      for (const imported of modules.getModuleInfo(one)?.importedIds ?? []) frontPage.add(imported);
  }
  return frontPage.has(id);
}

export default defineConfig({
  plugins: [heads, firstPaint],
  base: "/",
  build: {
    outDir: "dist",
    emptyOutDir: true,
    target: "es2022",
    // The pages' content policy allows scripts and styles from files only.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    rolldownOptions: {
      input: {
        index: page("index.html"),
        lecture: page("lecture.html"),
        lab: page("lab.html"),
        logs: page("logs.html"),
        join: page("join.html"),
        puzzles: page("puzzles.html"),
        fleet: page("fleet.html"),
        missing: page("missing.html"),
        scene: page("src/pages/scene.ts"),
      },
      // Few files: what two pages share is in one of them, and the pages' own small pieces are not torn out of it.
      output: {
        codeSplitting: {
          groups: [
            {
              name: (id, context) => (isOnFrontPage(id, context) ? "first" : null),
              debugName: "first",
              minShareCount: 2,
            },
            { name: "shared", minShareCount: 3 },
          ],
        },
        // The server puts this one into viser's page, see server/scenes/proxy.py.
        entryFileNames: ({ name }) => (name === "scene" ? "scene.js" : "assets/[name]-[hash].js"),
      },
    },
  },
  // Everything is written for one JSX factory, Preact's; oxc reads it from tsconfig.json.
  server: {
    // The lecture shows lines of mapper/mapping/textbook.py itself.
    fs: { allow: [".", page("../mapper")] },
    proxy: {
      "/api": { target: service, ws: true },
      "/scenes": { target: service, ws: true },
    },
  },
  // Most tests need no document; those that do name happy-dom in their first line: setting it up takes as long as they do.
  // A test that computes for a second on an idle machine takes ten on a busy one.
  // Without a worker of its own for each file all take a quarter of the time.
  test: { include: ["src/**/*.test.{ts,tsx}"], css: { include: /\?raw/ }, testTimeout: 60_000, isolate: false },
});
