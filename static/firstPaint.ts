/**
 * The first picture of the front page, drawn while the pages are built: the world and the robot's map of
 * `src/store/firstPicture.json`, in the HTML until the script runs, and as the preview of links to the page.
 */

import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { crc32, deflateSync } from "node:zlib";
import { decompress } from "fzstd";
import { LAB, LEGEND, LOGS, MORE, SENTENCE, TITLE } from "./src/pages/firstScreen";
import { palette } from "./src/render/map/palettes";
import FIRST from "./src/store/firstPicture.json";
import type { Rgb } from "./src/style/colour";
import { ICON_PATHS, type IconName } from "./src/ui/iconPaths";
import { SITE_PAGES } from "./src/ui/site/sitePages";
import { decodeFrame } from "./src/wire/decodeFrame";

/** Cells around the world that the picture shows. */
const MARGIN = 10;
/** Size of the preview of a link, and how many of its pixels a cell has. */
const PREVIEW = { width: 1200, height: 630, scale: 2 };

type Theme = "light" | "dark";

const TOKENS = readFileSync(resolve(import.meta.dirname, "src/style/tokens.css"), "utf8");

/** A colour of tokens.css in a theme, as it is written there. */
function token(name: string, theme: Theme): string {
  const pair = new RegExp(`--${name}: light-dark\\((#\\w{6}), (#\\w{6})\\)`).exec(TOKENS);
  const colour = pair?.[theme === "light" ? 1 : 2];
  if (!colour) throw new Error(`tokens.css has no colour --${name} of two themes.`);
  return colour;
}

const bytes = (colour: string): Rgb => {
  const all = Number.parseInt(colour.slice(1), 16);
  return [all >> 16, (all >> 8) & 255, all & 255];
};

interface Picture {
  readonly width: number;
  readonly height: number;
  /** One byte of the palette for each pixel, the first row on top. */
  readonly pixels: Uint8Array;
}

const message = <T>(type: string): T => FIRST.messages.find((one) => one.type === type) as unknown as T;

/** The cells of the world and a margin, the greatest y on top. */
function mapPicture(): Picture {
  const { rows, cols, resolution, origin, tile } = message<{
    rows: number;
    cols: number;
    resolution: number;
    origin: [number, number, number];
    tile: number;
  }>("geometry");
  const frame = decodeFrame(Uint8Array.from(atob(FIRST.tiles), (byte) => byte.charCodeAt(0)).buffer);
  if (frame.kind !== "tiles") throw new Error("The first picture begins with tiles.");
  const cells = new Uint8Array(rows * cols);
  for (const { tx, ty, data } of frame.tiles) {
    const values = decompress(data, new Uint8Array(tile * tile));
    for (let row = 0; row < tile; row++)
      for (let col = 0; col < tile; col++) {
        const [r, c] = [ty * tile + row, tx * tile + col];
        // int8 −128 is never observed: byte 0 of the palette.
        if (r < rows && c < cols) cells[r * cols + c] = ((values[row * tile + col] ?? 0) + 128) & 255;
      }
  }
  const [x0, y0, x1, y1] = message<{ bounds: [number, number, number, number] }>("world").bounds;
  const first = {
    col: Math.round((x0 - origin[0]) / resolution) - MARGIN,
    row: Math.round((y0 - origin[1]) / resolution) - MARGIN,
  };
  const width = Math.round((x1 - x0) / resolution) + 2 * MARGIN;
  const height = Math.round((y1 - y0) / resolution) + 2 * MARGIN;
  const pixels = new Uint8Array(width * height);
  for (let row = 0; row < height; row++)
    for (let col = 0; col < width; col++)
      pixels[(height - 1 - row) * width + col] = cells[(first.row + row) * cols + first.col + col] ?? 0;
  return { width, height, pixels };
}

/** The map enlarged, in the middle of the preview. */
function previewOf({ width, height, pixels }: Picture): Picture {
  const out = new Uint8Array(PREVIEW.width * PREVIEW.height);
  const [left, top] = [(PREVIEW.width - PREVIEW.scale * width) >> 1, (PREVIEW.height - PREVIEW.scale * height) >> 1];
  for (let y = 0; y < PREVIEW.height; y++)
    for (let x = 0; x < PREVIEW.width; x++) {
      const [col, row] = [Math.floor((x - left) / PREVIEW.scale), Math.floor((y - top) / PREVIEW.scale)];
      if (col >= 0 && row >= 0 && col < width && row < height)
        out[y * PREVIEW.width + x] = pixels[row * width + col] ?? 0;
    }
  return { width: PREVIEW.width, height: PREVIEW.height, pixels: out };
}

function chunk(type: string, data: Uint8Array): Buffer {
  const body = Buffer.concat([Buffer.from(type, "latin1"), data]);
  const [size, check] = [Buffer.alloc(4), Buffer.alloc(4)];
  size.writeUInt32BE(data.length);
  check.writeUInt32BE(crc32(body));
  return Buffer.concat([size, body, check]);
}

/** A PNG with a palette, see the PNG specification, 11.2. */
function png({ width, height, pixels }: Picture, theme: Theme): Buffer {
  const { low, high } = message<{ low: number; high: number }>("geometry");
  const colours = palette(
    { low, high },
    {
      unobserved: bytes(token("map-unobserved", theme)),
      free: bytes(token("map-free", theme)),
      undecided: bytes(token("map-undecided", theme)),
      occupied: bytes(token("map-occupied", theme)),
    },
  );
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  head.set([8, 3, 0, 0, 0], 8); // 8 bits, by a palette
  const table = Buffer.from(Array.from({ length: 256 }, (_, i) => [...colours.subarray(4 * i, 4 * i + 3)]).flat());
  const rows = Buffer.alloc(height * (width + 1)); // each row begins with its filter: none
  for (let row = 0; row < height; row++)
    rows.set(pixels.subarray(row * width, (row + 1) * width), row * (width + 1) + 1);
  return Buffer.concat([
    Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]),
    chunk("IHDR", head),
    chunk("PLTE", table),
    chunk("IDAT", deflateSync(rows, { level: 9 })),
    chunk("IEND", Buffer.alloc(0)),
  ]);
}

/** The world as an SVG of the same extent as the map. */
function world(theme: Theme): string {
  const { resolution } = message<{ resolution: number }>("geometry");
  const { bounds, polygons } = message<{ bounds: [number, number, number, number]; polygons: [number, number][][] }>(
    "world",
  );
  const [x, y] = message<{ pose: [number, number, number] }>("frame").pose;
  const [x0, y0, x1, y1] = bounds;
  const margin = MARGIN * resolution;
  const [width, height] = [x1 - x0 + 2 * margin, y1 - y0 + 2 * margin];
  const at = ([px, py]: readonly [number, number]): string =>
    `${(px - x0 + margin).toFixed(2)} ${(y1 + margin - py).toFixed(2)}`;
  const solid = polygons.map((polygon) => `M${polygon.map(at).join("L")}Z`).join("");
  const [cx, cy] = at([x, y]).split(" ");
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${height}"><rect x="${margin}" y="${margin}" width="${x1 - x0}" height="${y1 - y0}" fill="${token("surface", theme)}"/><path d="${solid}" fill="${token("map-solid", theme)}"/><circle cx="${cx}" cy="${cy}" r="0.35" fill="${token("robot", theme)}"/></svg>`;
}

interface Drawn {
  /** Path in the build, with a digest of the content. */
  readonly path: string;
  readonly content: string | Buffer;
}

function drawn(name: string, form: string, content: string | Buffer): Drawn {
  const digest = createHash("sha256").update(content).digest("hex").slice(0, 8);
  return { path: `assets/${name}-${digest}.${form}`, content };
}

const MAP = mapPicture();
const FILES = {
  map: drawn("first-map", "png", png(MAP, "light")),
  mapDark: drawn("first-map-dark", "png", png(MAP, "dark")),
  world: drawn("first-world", "svg", world("light")),
  worldDark: drawn("first-world-dark", "svg", world("dark")),
  preview: drawn("preview", "png", png(previewOf(MAP), "light")),
} as const;

/** The files of the first picture and of the preview. */
export const FIRST_PAINT_FILES: readonly Drawn[] = Object.values(FILES);

const picture = (light: Drawn, dark: Drawn, label: string): string =>
  `<picture><source srcset="/${dark.path}" media="(prefers-color-scheme: dark)"><img src="/${light.path}" alt="${label}" fetchpriority="high" decoding="sync"></picture>`;

/** What a page that links to this one shows of it. The service makes the address of the picture absolute. */
export const PREVIEW_TAGS = `<meta property="og:type" content="website">
    <meta property="og:title" content="Gridbloom: watch an occupancy grid map fill in">
    <meta property="og:description" content="Drag the inverse sensor model of a robot and see its whole map change; upload a log and inspect it.">
    <meta property="og:image" content="/${FILES.preview.path}">
    <meta property="og:image:width" content="${PREVIEW.width}">
    <meta property="og:image:height" content="${PREVIEW.height}">
    <meta name="twitter:card" content="summary_large_image">`;

const icon = (name: IconName): string =>
  `<svg class="icon" viewBox="0 0 24 24" aria-hidden="true"><path d="${ICON_PATHS[name]}"/></svg>`;

const plate = (title: string, actions: string, content: string): string =>
  `<section class="plate"><header class="plate-head"><h2>${title}</h2>${actions}</header><div class="plate-picture">${content}</div></section>`;

const links = SITE_PAGES.map(({ href, label }) => `<a href="${href}">${label}</a>`).join("");
const sentence = SENTENCE.map((part) =>
  typeof part === "string" ? part : `<b class="noun-${part.tone}">${part.text}</b>`,
).join("");
const legend = LEGEND.map(
  ({ name, label, note }) => `<li class="${name}">${label}${note ? `<span>${note}</span>` : ""}</li>`,
).join("");

/**
 * What the front page shows until its script runs: its header, words and pictures in the places that they keep. Of the
 * two buttons of the header, which need the script, there is the room only.
 */
export const FIRST_PAINT = `<header class="site-header"><a class="site-brand" href="/">${icon("logo")}<span>Gridbloom</span></a><nav aria-label="Pages">${links}</nav><span class="button quiet" aria-hidden="true">${icon("people")}<span class="class-button-text">Class</span></span><span class="button quiet icon-only" aria-hidden="true"><svg class="icon"></svg></span></header>
      <main id="main"><section class="hero first-paint" aria-label="A live map">
        <div class="hero-head"><h1>${TITLE}</h1><div class="actions"><a class="button primary" href="${LAB.href}">${LAB.label}</a><a class="button" href="${LOGS.href}">${LOGS.label}</a></div><p>${sentence}</p></div>
        <div class="hero-maps">
          ${plate("The world", "", picture(FILES.world, FILES.worldDark, "The floor plan of an office with a robot in it"))}
          ${plate("The map", `<div class="plate-actions"><ul class="map-legend">${legend}</ul></div>`, picture(FILES.map, FILES.mapDark, "The robot’s map of it so far"))}
        </div>
        <div class="hero-model"><div class="hero-curve"><noscript><p>The maps above are pictures of the start. With JavaScript the robot drives, and its sensor model can be changed here.</p></noscript></div><div class="hero-numbers">${"<div></div>".repeat(4)}</div></div>
        <p class="hero-facts"></p><a class="hero-more" href="${MORE.href}">${icon("unfold")} ${MORE.label}</a>
      </section></main>`;
