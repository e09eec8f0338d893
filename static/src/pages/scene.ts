/**
 * Script of the 3D view, inserted by server/scenes/proxy.py before those of viser's client: it makes glTF files of the
 * chunks of voxels, and clips point clouds, before the client reads the messages that they are in. The client begins
 * with the camera that the tab has kept, which viser takes from the query of the address. Before the first camera that a
 * person has moved the server is told that this one is not to be aimed again (server/scenes/scene.py).
 *
 * The client's worker passes messages on; a listener that is added when the worker is made hears them first.
 *
 * While the camera moves, clouds are drawn with as many points as the browser draws quickly enough.
 *
 * In a browser without WebGL 2 the client would log errors and leave the view empty: a sentence is shown instead.
 */

import { ClippedClouds, type NodeMessage } from "../render/voxels/clippedClouds";
import { PointBudget } from "../render/voxels/pointBudget";
import { voxelGlb } from "../render/voxels/voxelGlb";
import { decodeVoxels, isVoxelChunk } from "../wire/decodeVoxels";
import { FirstCamera, keptCamera, keptQuery, MovedCamera } from "./sceneCamera";
import { addGestures } from "./sceneGestures";

/** A message of viser; those with glTF files have them as `props.glb_data`. */
interface SceneMessage extends NodeMessage {
  readonly props?: { glb_data?: unknown; points?: unknown; colors?: unknown };
}

const firstCamera = new FirstCamera();
const clouds = new ClippedClouds();
const budget = new PointBudget();

/** When the present animation frame began, ms: the same in all of it. */
const frameTime = (): number => Number(document.timeline.currentTime ?? performance.now());

// Three.js draws a cloud by one call, which draws the first of its points alone while the camera moves.
const { drawArrays } = WebGL2RenderingContext.prototype;
WebGL2RenderingContext.prototype.drawArrays = function draw(mode, first, count): void {
  drawArrays.call(this, mode, first, mode === this.POINTS ? budget.take(count, frameTime()) : count);
};

function expand({ data }: MessageEvent<{ readonly type?: string; readonly messages?: SceneMessage[] }>): void {
  if (data?.type === "connected") camera.connected();
  camera.take(data?.messages ?? []);
  firstCamera.take(data?.messages ?? []);
  clouds.take(data?.messages ?? []);
  for (const { props } of data?.messages ?? []) {
    const file = props?.glb_data;
    if (props && file instanceof Uint8Array && isVoxelChunk(file)) props.glb_data = voxelGlb(decodeVoxels(file));
  }
}

/** What the tab keeps; null if the browser forbids it. */
const storage = (() => {
  try {
    return sessionStorage;
  } catch {
    return null;
  }
})();

const query = storage && keptQuery(storage, location);
if (query !== null) history.replaceState(null, "", query);
const camera = new MovedCamera(storage, location.pathname, location.search.includes("initialCameraPosition="));

window.sceneCamera = () => storage && keptCamera(storage, location.pathname);

window.Worker = class extends window.Worker {
  constructor(...given: ConstructorParameters<typeof Worker>) {
    super(...given);
    this.addEventListener("message", expand);
  }

  override postMessage(posted: { readonly message?: { readonly type?: string } }, ...more: unknown[]): void {
    if (posted?.message?.type === "ViewerCameraMessage") budget.moved();
    if (camera.reports(posted?.message)) {
      super.postMessage({ type: "send", message: { type: "CameraMovedMessage" } });
    }
    super.postMessage(posted, ...(more as [Transferable[]]));
  }
};

// The client posts the camera after the frame that shows it moved, which is to be a quick one already.
addEventListener("pointerdown", () => budget.hold(true), true);
for (const end of ["pointerup", "pointercancel", "blur"]) addEventListener(end, () => budget.hold(false), true);
addEventListener("wheel", () => budget.moved(), { capture: true, passive: true });
addEventListener("pointermove", ({ buttons }) => buttons !== 0 && camera.acted(), true);
for (const type of ["wheel", "keydown"]) addEventListener(type, () => camera.acted(), { capture: true, passive: true });
addGestures(window);

const WITHOUT_WEBGL =
  "This browser does not offer WebGL 2, with which the 3D view is drawn. Turn on hardware acceleration in the " +
  "browser’s settings, or open the page in another browser.";

/** Stop before the client begins, and show a sentence in the colours that the address asks for. */
function showSentence(sentence: string): void {
  window.stop();
  const text = Object.assign(document.createElement("p"), { textContent: sentence });
  const body = document.createElement("body");
  body.append(text);
  document.body?.remove();
  document.documentElement.append(body);
  document.documentElement.lang = "en";
  document.documentElement.style.colorScheme = new URLSearchParams(location.search).has("darkMode") ? "dark" : "light";
  body.style.cssText = "margin: 1rem; font: 1rem/1.5 system-ui, sans-serif; color: CanvasText; background: Canvas";
}

const context = document.createElement("canvas").getContext("webgl2");
context?.getExtension("WEBGL_lose_context")?.loseContext();
if (!context) showSentence(WITHOUT_WEBGL);
