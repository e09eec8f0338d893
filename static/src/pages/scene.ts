/**
 * Script of the 3D view, inserted by server/scenes/proxy.py before those of viser's client: it makes glTF files of the
 * chunks of voxels before the client reads the messages that they are in, and clips point clouds as they are drawn. The client begins
 * with the camera that the tab has kept, which viser takes from the query of the address. Before the first camera that a
 * person has moved the server is told that this one is not to be aimed again (server/scenes/scene.py).
 *
 * The client's worker passes messages on; a listener that is added when the worker is made hears them first.
 *
 * The canvas is hidden until the scene of a connection is told: before, viser's client draws axes of its own, from its own
 * first camera. The page around hears of it by the event `scene` of the frame.
 *
 * A frame draws as many points of clouds as the browser draws quickly enough; while the camera rests, further frames add
 * the others to the picture. `unsmoothed` in the address leaves edges as they are.
 *
 * In a browser without WebGL 2 the client would log errors and leave the view empty: a sentence is shown instead.
 */

import { ClippedClouds, clippingShader, type NodeMessage, PointClipper } from "../render/voxels/clippedClouds";
import { PointBudget } from "../render/voxels/pointBudget";
import { voxelGlb } from "../render/voxels/voxelGlb";
import { decodeVoxels, isVoxelChunk } from "../wire/decodeVoxels";
import { FirstCamera, keptCamera, keptQuery, MovedCamera } from "./sceneCamera";
import { addGestures, zoomAtCursor } from "./sceneGestures";
import { intervalUntilRest, SceneRest } from "./sceneRest";
import { UntilTold } from "./sceneTold";

/** A message of viser; those with glTF files have them as `props.glb_data`. */
interface SceneMessage extends NodeMessage {
  readonly props?: { glb_data?: unknown; readonly points?: unknown };
}

const firstCamera = new FirstCamera();
const clouds = new ClippedClouds();
const clipper = new PointClipper(clouds);
const budget = new PointBudget();

/** Start of the present animation frame, ms; constant within it. */
const frameTime = (): number => Number(document.timeline.currentTime ?? performance.now());

/** The worker of viser's client, once it has a connection. */
let client: Worker | null = null;

/** Make viser's client draw another frame while the picture lacks points, as after a message without effect. */
function goOn(): void {
  const messages = [{ type: "RunJavascriptMessage", source: "" }];
  if (client && budget.lacks)
    client.onmessage?.(new MessageEvent("message", { data: { type: "message_batch", messages } }));
}

const rest = new SceneRest();
const isAtRest = (): boolean => rest.isAtRest(performance.now());
window.setInterval = intervalUntilRest(window.setInterval.bind(window), isAtRest) as typeof window.setInterval;
const changed = (): void => rest.changed(performance.now());
for (const type of ["pointerdown", "pointermove", "wheel", "keydown", "resize", "focus"]) {
  addEventListener(type, changed, { capture: true, passive: true });
}

/** Of the canvas, until it contains points drawn here. */
const hiding = new CSSStyleSheet();
hiding.replaceSync("canvas { visibility: hidden !important }");
document.adoptedStyleSheets = [...document.adoptedStyleSheets, hiding];
const waiting = new UntilTold();

function show(isShown: boolean): void {
  hiding.disabled = isShown;
  frameElement?.dispatchEvent(new CustomEvent("scene", { detail: isShown }));
}

/** A frame that only adds points draws nothing else on the canvas and does not clear it. */
const gl = WebGL2RenderingContext.prototype;
const { clear, drawArrays, drawArraysInstanced, drawElements, drawElementsInstanced } = gl;
const { bufferData, bufferSubData, shaderSource } = gl;
gl.shaderSource = function compile(shader, source): void {
  shaderSource.call(this, shader, clippingShader(source));
};
gl.bufferData = function write(...given: unknown[]): void {
  Reflect.apply(bufferData, this, given);
  clipper.wrote(this, given[1]);
};
gl.bufferSubData = function write(...given: unknown[]): void {
  Reflect.apply(bufferSubData, this, given);
  clipper.wrote(this, given[2]);
};
let size = "";
function skips(context: WebGL2RenderingContext): boolean {
  if (context.getParameter(context.FRAMEBUFFER_BINDING)) return false;
  const now = `${context.drawingBufferWidth} ${context.drawingBufferHeight}`;
  if (now !== size) budget.changed(); // a canvas of another size is empty
  size = now;
  return budget.adds(frameTime());
}
gl.clear = function clearAll(mask): void {
  if (!skips(this)) clear.call(this, mask);
};
// Three.js draws a cloud with one call.
gl.drawArrays = function draw(mode, first, count): void {
  if (mode === this.POINTS) {
    clipper.prepare(this);
    const slice = budget.take(count, frameTime());
    if (budget.lacks) requestAnimationFrame(goOn);
    drawArrays.call(this, mode, first + slice.first, slice.count);
    return;
  }
  budget.note(count, frameTime());
  if (!skips(this)) drawArrays.call(this, mode, first, count);
};
gl.drawArraysInstanced = function draw(mode, first, count, instances): void {
  budget.note(count, frameTime());
  if (!skips(this)) drawArraysInstanced.call(this, mode, first, count, instances);
};
gl.drawElements = function draw(mode, count, type, offset): void {
  budget.note(count, frameTime());
  if (!skips(this)) drawElements.call(this, mode, count, type, offset);
};
gl.drawElementsInstanced = function draw(mode, count, type, offset, instances): void {
  budget.note(count, frameTime());
  if (!skips(this)) drawElementsInstanced.call(this, mode, count, type, offset, instances);
};

type WorkerMessage = MessageEvent<{ readonly type?: string; readonly messages?: SceneMessage[] }>;

function expand({ data, currentTarget }: WorkerMessage): void {
  if (data?.type === "connected") {
    client = currentTarget as Worker;
    camera.connected();
    waiting.connected();
    show(false);
  }
  if (data?.messages?.some(({ type }) => !type?.startsWith("Gui"))) budget.changed();
  changed();
  camera.take(data?.messages ?? []);
  firstCamera.take(data?.messages ?? []);
  // The client processes messages in the frame after their arrival.
  if (waiting.isTold(data?.messages ?? [], firstCamera.isKnown, camera.isMoved)) {
    requestAnimationFrame(() => requestAnimationFrame(() => show(true)));
  }
  if (clouds.take(data?.messages ?? [])) budget.moved(); // a face of the box is dragged: quick frames, as for a camera
  for (const { props } of data?.messages ?? []) {
    const file = props?.glb_data;
    if (props && file instanceof Uint8Array && isVoxelChunk(file)) props.glb_data = voxelGlb(decodeVoxels(file));
  }
}

/** The state stored by the tab; null if the browser forbids it. */
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

// The client posts the camera after the frame with its motion, which should already be a fast one.
addEventListener("pointerdown", () => budget.hold(true), true);
for (const end of ["pointerup", "pointercancel", "blur"]) addEventListener(end, () => budget.hold(false), true);
addEventListener("wheel", () => budget.moved(), { capture: true, passive: true });
/** In a hidden view nobody can act: its camera moves as the server requests. */
const acted = (): void => {
  if (hiding.disabled) camera.acted();
};
addEventListener("pointermove", ({ buttons }) => buttons !== 0 && acted(), true);
for (const type of ["wheel", "keydown"]) addEventListener(type, acted, { capture: true, passive: true });
addGestures(window);
zoomAtCursor(Object.prototype);

const WITHOUT_WEBGL =
  "This browser does not offer WebGL 2, with which the 3D view is drawn. Turn on hardware acceleration in the " +
  "browser’s settings, or open the page in another browser.";

/** Stop before the client starts, and show a sentence in the colours requested by the address. */
function showSentence(sentence: string): void {
  window.stop();
  const text = Object.assign(document.createElement("p"), { textContent: sentence });
  const body = document.createElement("body");
  body.append(text);
  document.body?.remove();
  document.documentElement.append(body);
  document.documentElement.lang = "en";
  document.documentElement.style.colorScheme = new URLSearchParams(location.search).has("darkMode") ? "dark" : "light";
  show(true);
  body.style.cssText = "margin: 1rem; font: 1rem/1.5 system-ui, sans-serif; color: CanvasText; background: Canvas";
}

/** Have contexts that are made from now on leave edges as they are. */
function withoutSmoothing(): void {
  const { getContext } = HTMLCanvasElement.prototype;
  HTMLCanvasElement.prototype.getContext = function get(this: HTMLCanvasElement, id: string, attributes?: object) {
    return getContext.call(this, id, id === "webgl2" ? { ...attributes, antialias: false } : attributes);
  } as typeof getContext;
}

if (new URLSearchParams(location.search).has("unsmoothed")) withoutSmoothing();
const context = document.createElement("canvas").getContext("webgl2");
context?.getExtension("WEBGL_lose_context")?.loseContext();
if (!context) showSentence(WITHOUT_WEBGL);
