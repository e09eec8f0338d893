import type { Signal } from "@preact/signals";
import { Button } from "../../../ui/Button";
import { type Layout, withAdded } from "../../../ui/stage/layout";
import { showView } from "../../../ui/stage/Stage";
import type { ContentsState } from "../contents/useContents";
import { hasClouds, type Solid } from "../views/solid";
import { SOLID_VIEW } from "../views/views";

interface OpenIn3dProps {
  /** Of the log; null for a guest, who cannot open its page. */
  readonly id: string | null;
  readonly contents: ContentsState;
  readonly solid: Solid;
  readonly layout: Signal<Layout>;
}

/**
 * Shows the point clouds of a log in the 3D view of the stage, and links to their own page with all settings. Nothing
 * for a log without clouds.
 */
export function OpenIn3d({ id, contents, solid, layout }: OpenIn3dProps) {
  if (!hasClouds(contents)) return null;
  return (
    <Button
      icon="cube"
      label="Open in 3D"
      {...(id === null ? {} : { href: `/logs.html?${new URLSearchParams({ log: id, volume: "" })}` })}
      onClick={(event) => {
        if (event.ctrlKey || event.metaKey || event.shiftKey || event.altKey) return;
        event.preventDefault();
        solid.clouds.value = true;
        layout.value = withAdded(layout.peek(), SOLID_VIEW);
        showView(SOLID_VIEW);
      }}
    />
  );
}
