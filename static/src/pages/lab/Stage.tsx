/** The stage of the lab: its views, and the borders between them. */

import type { Signal } from "@preact/signals";
import type { Layout } from "../../ui/stage/layout";
import { Stage as Views } from "../../ui/stage/Stage";
import { type LabPictures, viewsOf, WORLD_AND_MAP } from "./views";
import "./stage.css";

interface StageProps extends LabPictures {
  readonly layout: Signal<Layout>;
  /** Whether nothing in it can be used. */
  readonly isInert: boolean;
}

export function Stage({ layout, isInert, ...pictures }: StageProps) {
  const now = layout.value;
  return (
    <div class="lab-stage" inert={isInert}>
      <Views
        views={viewsOf(pictures)}
        layout={now}
        onLayout={(next) => {
          layout.value = next;
        }}
        isTogether={now.arrangement === "beside" && `${now.views}` === `${WORLD_AND_MAP.views}`}
      />
    </div>
  );
}
