import { computed, useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useLayoutEffect, useMemo, useRef } from "preact/hooks";
import { type LaterId, later } from "../../lessons/stage/later";
import { SCENES, type SceneId } from "../../lessons/stage/scenes";
import { WorldStage } from "../../lessons/stage/WorldStage";
import { printing } from "../../ui/browser/theme";
import { awaitFigure } from "./awaitedFigures";
import { LESSONS, type LessonId } from "./lessons";
import { SlideQuestion } from "./present/SlideQuestion";
import { place, presenting, shownOf, stage } from "./present/state";
import { useFittedFigure } from "./present/useFittedFigure";
import { SHORT, type SourceName } from "./sources";

interface LazyFigureProps {
  /** Render the figure immediately, wherever it is. */
  readonly now: boolean;
  readonly children: ComponentChildren;
}

/** A figure that is rendered when it is near the window, when it is printed, or when the page is idle. */
function LazyFigure({ now, children }: LazyFigureProps) {
  const box = useRef<HTMLDivElement>(null);
  const near = useSignal(now);
  const isHere = near.value || now || printing.value;
  useLayoutEffect(() => {
    if (isHere) near.value = true;
    if (isHere || !box.current) return;
    return awaitFigure(box.current, () => {
      near.value = true;
    });
  }, [isHere, near]);
  return (
    <div class={isHere ? "" : "figure-awaited"} ref={box}>
      {isHere && children}
    </div>
  );
}

/** The puzzle about the fault that this section explains. */
const PUZZLES: Readonly<Record<string, readonly [name: string, title: string]>> = {
  endpoint: ["integers", "Right in one corner"],
  forgetting: ["ghost", "Detours"],
  "low-table": ["collision", "A perfect map"],
  mount: ["bumped", "Blurred straight ahead"],
  "no-return": ["arcs", "Walls in the open"],
  odometry: ["worn", "The second building"],
  people: ["visitors", "Open day"],
  polished: ["leak", "Free space outside"],
  resolution: ["doorway", "The closed doors"],
  sonar: ["cones", "Sixteen numbers"],
  window: ["thick", "The thick walls"],
};

/** Properties that the list of sections passes to each. */
export interface SectionHead {
  readonly id: string;
  readonly number: number;
  readonly title: string;
}

interface SectionProps extends SectionHead {
  readonly figure: ComponentChildren;
  /** The text before and after the figure. */
  readonly children: ComponentChildren;
  readonly after?: ComponentChildren;
  /** A prediction about the figure, below it; slides have separate questions. */
  readonly predict?: ComponentChildren;
  readonly sources: readonly (SourceName | readonly [SourceName, string])[];
}

/** One lesson: a heading, text, one interactive figure, and the sources. */
export function Section({ id, number, title, figure, children, after, predict, sources }: SectionProps) {
  const shown = shownOf(id);
  const puzzle = PUZZLES[id];
  const frame = useFittedFigure(shown === "section");
  return (
    <section
      class={`lesson${shown ? ` on-slide shows-${shown}` : ""}`}
      {...(shown ? { "data-stage": stage.value, "data-step": place.value.step } : {})}
      id={id}
      data-scene={id}
      aria-labelledby={`${id}-title`}
      hidden={presenting.value && !shown}
    >
      <h2 id={`${id}-title`}>
        <a class="lesson-number" href={`#${id}`} title="Link to this section">
          {number}
        </a>{" "}
        {title}
      </h2>
      <div class="prose">{children}</div>
      {shown === "section" && <SlideQuestion id={id} />}
      <div class="lesson-room">
        <div class="lesson-figure" ref={frame}>
          <LazyFigure now={shown === "section"}>{figure}</LazyFigure>
        </div>
      </div>
      {!shown && predict}
      {after && <div class="prose">{after}</div>}
      {(sources.length > 0 || puzzle) && (
        <footer class="lesson-sources">
          {sources.length > 0 && (
            <p>
              Sources:{" "}
              {sources.map((source, i) => {
                const [name, place] = typeof source === "string" ? [source, ""] : source;
                return (
                  <span key={name}>
                    {i > 0 && "; "}
                    {SHORT[name]}
                    {place && (place.startsWith("(") ? ` ${place}` : `, ${place}`)}
                  </span>
                );
              })}
              .
            </p>
          )}
          {puzzle && (
            <p class="no-print">
              Puzzle: <a href={`/puzzles.html?puzzle=${puzzle[0]}`}>{puzzle[1]}</a>.
            </p>
          )}
        </footer>
      )}
    </section>
  );
}

/** "section 4" as a link; the number is that of the section's present position. */
export function SectionLink({ to, capital = false }: { readonly to: LessonId; readonly capital?: boolean }) {
  const number = LESSONS.findIndex(({ id }) => id === to) + 1;
  return (
    <a href={`#${to}`}>
      {capital ? "Section" : "section"} {number}
    </a>
  );
}

interface OnStageProps {
  readonly scene: SceneId;
  /** Description for screen readers. */
  readonly label: string;
  /** Controls of the scene, and its numbers. */
  readonly children?: ComponentChildren;
}

/**
 * A figure whose picture is the stage. On a slide and in print, where there is no stage, the figure contains the
 * picture.
 */
export function OnStage({ scene, label, children }: OnStageProps) {
  const now = useMemo(() => computed(() => SCENES[scene]()), [scene]);
  return (
    <figure class="on-stage" aria-label={label}>
      {(presenting.value || printing.value) && <WorldStage scene={now} still={printing.value} />}
      <div class="on-stage-controls">{children}</div>
    </figure>
  );
}

/** The figure of a section whose code loads after the first ones; empty on a slide until then. */
export function LaterFigure({ id }: { readonly id: LaterId }) {
  const Figure = later.value?.[id].figure;
  return Figure ? <Figure /> : <figure aria-busy="true" />;
}

/** The figure in the text after such a section's figure. */
export function LaterMore({ id }: { readonly id: LaterId }) {
  const More = later.value?.[id].more;
  return <div class="lesson-more">{More && <More />}</div>;
}
