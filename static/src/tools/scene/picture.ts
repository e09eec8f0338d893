/** The picture of a 3D view as a file. */

import { saveAs } from "../../ui/files/saveAs";
import { toast } from "../../ui/Toast";

/** Save what the 3D view in a part of the page shows, on the ground of its own page, as a PNG of as many pixels. */
export function savePicture(part: HTMLElement | null): void {
  const inside = part?.querySelector("iframe")?.contentDocument;
  const drawn = inside?.querySelector<HTMLCanvasElement>("canvas[data-engine]");
  const picture = document.createElement("canvas");
  const ctx = picture.getContext("2d");
  if (!inside || !drawn || !ctx) {
    toast("The 3D view has not loaded yet.", "error");
    return;
  }
  picture.width = drawn.width;
  picture.height = drawn.height;
  ctx.fillStyle = getComputedStyle(inside.body).backgroundColor;
  ctx.fillRect(0, 0, picture.width, picture.height);
  ctx.drawImage(drawn, 0, 0);
  picture.toBlob((png) => png && saveAs("view.png", png));
}
