import { computed } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useMemo } from "preact/hooks";
import { SCENES, type SceneId } from "../../lessons/stage/scenes";
import { WorldStage } from "../../lessons/stage/WorldStage";
import { printing } from "../../ui/browser/theme";
import { presenting } from "./present/state";

interface OnStageProps {
  readonly scene: SceneId;
  /** Description for screen readers. */
  readonly label: string;
  /** Controls of the scene, and what it says in numbers. */
  readonly children?: ComponentChildren;
}

/** A figure whose picture is the stage; on a slide and in print, where no stage is, it contains the picture. */
export function OnStage({ scene, label, children }: OnStageProps) {
  const now = useMemo(() => computed(() => SCENES[scene]()), [scene]);
  return (
    <figure class="on-stage" aria-label={label}>
      {(presenting.value || printing.value) && <WorldStage scene={now} still={printing.value} />}
      <div class="on-stage-controls">{children}</div>
    </figure>
  );
}
