/** The upload of files: several at the same time, each with as many connections as needed. */

import { signal } from "@preact/signals";
import { awaited } from "../../../ui/browser/awaited";
import { addressOf, answerIn, ask, isPassing, refusalIn } from "../../../wire/ask";
import { arrived, EVERYTHING, refresh, wanted } from "./library";

/** A file that is being uploaded. */
export interface Upload {
  readonly key: number;
  readonly name: string;
  readonly bytes: number;
  readonly sent: number;
  readonly error: string | null;
  /** When the present connection started to send (performance.now), and the bytes sent before; null while it waits. */
  readonly since: { readonly at: number; readonly sent: number } | null;
}

export const uploads = signal<readonly Upload[]>([]);

let nextKey = 1;

const patch = (key: number, change: Partial<Upload>): void => {
  uploads.value = uploads.value.map((upload) => (upload.key === key ? { ...upload, ...change } : upload));
};

export const dismiss = (key: number): void => {
  uploads.value = uploads.value.filter((upload) => upload.key !== key);
};

const requests = new Map<number, XMLHttpRequest>();

/** Cancel an upload, and make the server delete its part. */
export function cancel(key: number): void {
  dismiss(key);
  requests.get(key)?.abort();
}

const isCancelled = (key: number): boolean => !uploads.peek().some((upload) => upload.key === key);

const TRIES = 6; // in a row without progress
const PAUSE_MS = 1000;
const INTERRUPTED = "The upload was interrupted: the server does not answer.";

/** A random, unique name for an upload. */
function newKey(): string {
  const bytes = crypto.getRandomValues(new Uint8Array(18));
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** Number of bytes that the server has of an upload; null if it does not answer. */
async function offsetOf(name: string): Promise<number | null> {
  try {
    return (await ask("GET /api/logs/uploads/{key}", { key: name })).offset;
  } catch {
    return null;
  }
}

const MAX_CONCURRENT = 3; // uploads at a time; the server limits the uploads of all visitors
const waiting: (() => Promise<void>)[] = [];
let sending = 0;

/** Upload files. A single log is opened once it has been read. */
export function uploadAll(files: readonly File[]): void {
  wanted.value = EVERYTHING;
  arrived.value = null;
  for (const file of files) upload(file, files.length === 1);
}

/** Upload a file after the previous ones; after an interruption, resume at the server's offset. */
export function upload(file: File, opens = false): void {
  const key = nextKey++;
  uploads.value = [...uploads.value, { key, name: file.name, bytes: file.size, sent: 0, error: null, since: null }];
  if (file.size === 0) {
    patch(key, { error: "The file is empty." });
    return;
  }
  waiting.push(() => sendAll(key, newKey(), file, opens));
  sendNext();
}

function sendNext(): void {
  const next = sending < MAX_CONCURRENT ? waiting.shift() : undefined;
  if (!next) return;
  sending += 1;
  void next().finally(() => {
    sending -= 1;
    sendNext();
  });
}

async function sendAll(key: number, name: string, file: File, opens: boolean): Promise<void> {
  let most = 0;
  for (let tries = 0, offset = 0; ; ) {
    const answer = isCancelled(key) ? null : await awaited(send(key, name, file, offset));
    if (!answer || isCancelled(key)) {
      if (answer) await ask("DELETE /api/logs/uploads/{key}", { key: name }).catch(() => undefined);
      return;
    }
    if (answer.ok) {
      if (opens) arrived.value = (await answerIn<"PUT /api/logs">(answer)).id;
      dismiss(key);
      break;
    }
    tries += 1;
    // 409: another connection is still sending it, or the next part starts at another offset
    if (!(answer.status === 409 || isPassing(answer.status || null)) || tries >= TRIES) {
      patch(key, { error: answer.status === 0 ? INTERRUPTED : await refusalIn(answer) });
      break;
    }
    await new Promise((resolve) => setTimeout(resolve, PAUSE_MS * 2 ** (tries - 1)));
    const known = await offsetOf(name);
    if (known === null) continue;
    if (known > most) tries = 0;
    most = Math.max(most, known);
    offset = known;
  }
  void refresh();
}

/**
 * Send the rest of a file; {@link Response.error} if there was no answer. It uses XMLHttpRequest, because fetch does
 * not report the progress of an upload.
 */
function send(key: number, name: string, file: File, offset: number): Promise<Response> {
  return new Promise((resolve) => {
    const request = new XMLHttpRequest();
    request.open("PUT", addressOf("PUT /api/logs", {}, { name: file.name, upload: name }));
    request.setRequestHeader("Content-Type", "application/octet-stream");
    request.setRequestHeader("Content-Range", `bytes ${offset}-${file.size - 1}/${file.size}`);
    request.upload.onprogress = (event) => patch(key, { sent: offset + event.loaded });
    request.onloadend = () => {
      requests.delete(key);
      const { status, responseText } = request;
      resolve(status === 0 ? Response.error() : new Response(responseText, { status }));
    };
    requests.set(key, request);
    patch(key, { sent: offset, since: { at: performance.now(), sent: offset } });
    request.send(file.slice(offset));
  });
}
