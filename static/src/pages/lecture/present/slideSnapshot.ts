/** A small picture of a page: its document as an SVG image with the element foreignObject of SVG 2, section 12.4. */

/** The rules of all style sheets. Fonts are omitted, because an SVG image loads nothing. */
function rulesOf(page: Document): string {
  const rules = [...page.styleSheets].flatMap((sheet) => [...sheet.cssRules]);
  return rules
    .map((rule) => rule.cssText)
    .filter((text) => !text.startsWith("@font-face"))
    .join("\n");
}

/** A canvas of this size whose pixels are read back; without a graphics processor, from which reading is slower. */
function readable(width: number, height: number): [HTMLCanvasElement, CanvasRenderingContext2D] {
  const canvas = document.createElement("canvas");
  canvas.width = Math.max(1, Math.round(width));
  canvas.height = Math.max(1, Math.round(height));
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (!context) throw new Error("no canvas");
  context.imageSmoothingQuality = "high";
  return [canvas, context];
}

/** The content of a canvas as the address of an image that is `width` pixels wide. */
function canvasImage(from: HTMLCanvasElement, width: number): string {
  const [canvas, context] = readable(width, (width * from.height) / from.width);
  context.drawImage(from, 0, 0, canvas.width, canvas.height);
  return canvas.toDataURL();
}

/**
 * A copy of an element as displayed, without what `omitted` selects. Canvases become background images with `scale`
 * pixels per CSS pixel.
 */
function stillCopy(root: HTMLElement, omitted: string, scale: number): HTMLElement {
  const copy = root.cloneNode(true) as HTMLElement;
  const drawn = root.querySelectorAll("canvas");
  const view = root.ownerDocument.defaultView;
  copy.querySelectorAll("canvas").forEach((canvas, i) => {
    const from = drawn[i];
    if (!from || !view || from.closest(omitted) || from.width === 0 || from.height === 0) return;
    const { display, width, height } = view.getComputedStyle(from);
    canvas.style.display = display === "inline" ? "inline-block" : display;
    canvas.style.width = width;
    canvas.style.height = height;
    const picture = canvasImage(from, Math.min(from.width, from.clientWidth * scale));
    canvas.style.background = `url(${picture}) 0 0 / 100% 100% no-repeat`;
  });
  for (const element of copy.querySelectorAll(omitted)) element.remove();
  return copy;
}

const escaped = (text: string): string => text.replaceAll("&", "&amp;").replaceAll("<", "&lt;");

/**
 * An SVG image of a document in the light or dark colours. It is assembled as text, because the Content-Security-Policy
 * of this page would forbid the styles in a document.
 */
function imageSource(page: Document, { width, height, to, dark, omitted }: SnapshotOptions): string {
  const root = page.documentElement;
  const { fontSize } = (page.defaultView as Window).getComputedStyle(root);
  const content = new XMLSerializer().serializeToString(
    stillCopy(root, `script, link, style, iframe, ${omitted}`, to / width),
  );
  // The root of the image, to which rem and the design tokens refer, is not the root of the page.
  const style = `font-size: ${fontSize}; color-scheme: ${dark ? "dark" : "light"}`;
  const image =
    `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" style="${style}">` +
    `<style>${escaped(rulesOf(page))}</style>` +
    `<foreignObject width="100%" height="100%">${content}</foreignObject></svg>`;
  return `data:image/svg+xml;charset=utf-8,${encodeURIComponent(image)}`;
}

interface SnapshotOptions {
  /** The size of the page, CSS pixels. */
  readonly width: number;
  readonly height: number;
  /** The width of the picture, pixels. */
  readonly to: number;
  readonly dark: boolean;
  /** Selects what is omitted. */
  readonly omitted: string;
}

/** Draw a document of this origin and return the address of the picture. Rejects if the browser does not allow it. */
export async function snapshotOf(page: Document, options: SnapshotOptions): Promise<string> {
  const { width, height, to } = options;
  const image = new Image(width, height);
  image.src = imageSource(page, options);
  await image.decode();
  const [canvas, context] = readable(to, (to * height) / width);
  context.drawImage(image, 0, 0, canvas.width, canvas.height);
  const blob = await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve));
  if (!blob) throw new Error("no picture");
  return URL.createObjectURL(blob);
}
