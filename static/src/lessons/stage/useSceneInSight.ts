import { computed, useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useMemo } from "preact/hooks";
import { useSeen } from "../common/useSteps";
import type { Scene } from "./scene";

/**
 * The scene for a figure that computes its whole map when it is drawn. While the figure is out of sight, its scene
 * stays as it was, so that a handle that is dragged elsewhere does not wait for maps that nobody sees.
 */
export function useSceneInSight(figure: RefObject<Element | null>, current: () => Scene): Scene {
  const isSeen = useSeen(figure);
  const isPrinted = useSignal(false);
  useEffect(() => {
    const print = (): void => {
      isPrinted.value = true;
    };
    const end = (): void => {
      isPrinted.value = false;
    };
    addEventListener("beforeprint", print);
    addEventListener("afterprint", end);
    return () => {
      removeEventListener("beforeprint", print);
      removeEventListener("afterprint", end);
    };
  }, [isPrinted]);
  const scene = useMemo(() => {
    let last: Scene | null = null;
    return computed(() => {
      if (isSeen.value || isPrinted.value || !last) last = current();
      return last;
    });
  }, [current, isSeen, isPrinted]);
  return scene.value;
}
