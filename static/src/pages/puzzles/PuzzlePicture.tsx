import { useSignal } from "@preact/signals";
import { isDark } from "../../ui/browser/theme";
import { Icon } from "../../ui/Icon";
import type { OfferedPuzzle } from "../../wire/http";

/** The map that an attempt at a puzzle begins with. */
export function PuzzlePicture({ puzzle }: { readonly puzzle: OfferedPuzzle }) {
  const state = useSignal<"awaited" | "shown" | "failed">("awaited");
  return (
    <div class={`card-picture ${state.value}`}>
      {state.value !== "shown" && <Icon name="map" />}
      {state.value !== "failed" && (
        <img
          src={`/api/puzzles/${encodeURIComponent(puzzle.name)}/map.png?dark=${isDark.value}`}
          alt={`Map of ${puzzle.title}`}
          loading="lazy"
          decoding="async"
          onLoad={() => {
            state.value = "shown";
          }}
          onError={() => {
            state.value = "failed";
          }}
        />
      )}
    </div>
  );
}
