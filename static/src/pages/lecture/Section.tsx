import type { ComponentChildren } from "preact";
import { LazyFigure } from "./LazyFigure";
import { SlideQuestion } from "./present/SlideQuestion";
import { place, presenting, shownOf, stage } from "./present/state";
import { useFittedFigure } from "./present/useFittedFigure";
import { SOURCES, type SourceName } from "./sources";

/** Sections about what goes wrong with a map: there are puzzles on each. */
const WITH_PUZZLES: ReadonlySet<string> = new Set([
  "endpoint",
  "forgetting",
  "low-table",
  "mount",
  "no-return",
  "odometry",
  "people",
  "polished",
  "resolution",
  "sonar",
  "window",
]);

/** What the list of sections gives to each. */
export interface SectionHead {
  readonly id: string;
  readonly number: number;
  readonly title: string;
}

interface SectionProps extends SectionHead {
  readonly figure: ComponentChildren;
  /** The text before the figure, and after it. */
  readonly children: ComponentChildren;
  readonly after?: ComponentChildren;
  /** A guess about the figure, below it; slides have questions of their own. */
  readonly predict?: ComponentChildren;
  readonly sources: readonly (SourceName | readonly [SourceName, string])[];
}

/** One lesson: a heading, text, one interactive figure, and the sources. */
export function Section({ id, number, title, figure, children, after, predict, sources }: SectionProps) {
  const shown = shownOf(id);
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
      {sources.length > 0 && (
        <footer class="lesson-sources">
          <h3>Sources</h3>
          <ul>
            {sources.map((source) => {
              const [name, place] = typeof source === "string" ? [source, ""] : source;
              return (
                <li key={name}>
                  {SOURCES[name]}
                  {place && `, ${place}`}.
                </li>
              );
            })}
          </ul>
          {WITH_PUZZLES.has(id) && (
            <p>
              Exercise: find this fault, and others, in the <a href="/puzzles.html">puzzles</a>.
            </p>
          )}
        </footer>
      )}
    </section>
  );
}
