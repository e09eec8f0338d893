import { signal } from "@preact/signals";
import { type ComponentType, createElement, type FunctionComponent } from "preact";
import { useEffect } from "preact/hooks";
import { awaited } from "./browser/awaited";

const RETRY_MS = 3000;

/** A component whose code is fetched when it is first shown, with retries while the server does not answer. */
export function lazy<Props extends object>(load: () => Promise<ComponentType<Props>>): FunctionComponent<Props> {
  const loaded = signal<{ readonly part: ComponentType<Props> } | null>(null);
  let isAsked = false;
  const ask = async (): Promise<void> => {
    if (isAsked) return;
    isAsked = true;
    try {
      loaded.value = { part: await awaited(load()) };
    } catch {
      isAsked = false;
      setTimeout(() => void ask(), RETRY_MS);
    }
  };
  return (props) => {
    useEffect(() => void ask(), []);
    return loaded.value && createElement(loaded.value.part, props);
  };
}
