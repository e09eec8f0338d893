/** The text frames of the stream: JSON, validated field by field. */

import { KINDS } from "./kinds";
import { CLASS_FIELDS, FIELDS } from "./messages";
import { type ClassMessage, ProtocolError, type ServerMessage, SUBPROTOCOL } from "./protocol";

/**
 * Read a message of a class. Throws {@link OutdatedPageError} for an unknown type, such as the `hello` with which a
 * server of another version requests a reload, and {@link ProtocolError} for an invalid message.
 */
export function decodeClassText(text: string): ClassMessage {
  let message: unknown;
  try {
    message = JSON.parse(text);
  } catch {
    throw new ProtocolError("message.json", "A text frame is one JSON object; this is not JSON.");
  }
  const { type } = (message ?? {}) as Record<string, unknown>;
  if (typeof type !== "string" || !Object.hasOwn(CLASS_FIELDS, type))
    throw new OutdatedPageError("message.unknown", "This page knows no such message of a class.");
  for (const [key, check] of Object.entries(CLASS_FIELDS[type as ClassMessage["type"]]))
    if (!check((message as Record<string, unknown>)[key]))
      throw new ProtocolError(`${type}.${key}`, `"${key}" of "${type}" cannot be read.`);
  return message as ClassMessage;
}

/** A frame of a server that is newer than this page, which must be reloaded. */
export class OutdatedPageError extends ProtocolError {
  constructor(code: string, message: string) {
    super(code, message);
    this.name = "OutdatedPageError";
  }
}

/**
 * Read a text frame. Throws {@link OutdatedPageError} for an unknown type, session kind or protocol, and
 * {@link ProtocolError} for an invalid message.
 */
export function decodeText(text: string): ServerMessage {
  let message: unknown;
  try {
    message = JSON.parse(text);
  } catch {
    throw new ProtocolError("message.json", "A text frame is one JSON object; this is not JSON.");
  }
  const { type, kind, protocol } = (message ?? {}) as Record<string, unknown>;
  if (typeof message !== "object" || Array.isArray(message) || typeof type !== "string") {
    throw new ProtocolError("message.type", 'A text frame is a JSON object with a "type".');
  }
  if (!Object.hasOwn(FIELDS, type)) {
    throw new OutdatedPageError("message.unknown", `This page knows no message "${type.slice(0, 80)}".`);
  }
  const fields = FIELDS[type as ServerMessage["type"]];
  if (type === "hello") {
    if (typeof kind === "string" && !Object.hasOwn(KINDS, kind)) {
      throw new OutdatedPageError("hello.kind", `This page knows no session kind "${kind.slice(0, 80)}".`);
    }
    if (typeof protocol === "string" && protocol !== SUBPROTOCOL) {
      throw new OutdatedPageError("hello.protocol", `This page knows no protocol "${protocol.slice(0, 80)}".`);
    }
  }
  for (const [key, check] of Object.entries(fields)) {
    const value = (message as Record<string, unknown>)[key];
    if (!check(value)) {
      const shown = JSON.stringify(value)?.slice(0, 80) ?? "missing";
      throw new ProtocolError(`${type}.${key}`, `"${key}" of "${type}" cannot be ${shown}.`);
    }
  }
  return message as ServerMessage;
}
