/** The text frames of a class: JSON, validated field by field. */

import { OutdatedPageError } from "./decodeText";
import { CLASS_FIELDS } from "./messages";
import { type ClassMessage, ProtocolError } from "./protocol";

/**
 * Read a message of a class. Throws {@link OutdatedPageError} for a type that this page does not know, as the `hello`
 * by which a server of another version asks for a reload, and {@link ProtocolError} for an invalid message.
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
