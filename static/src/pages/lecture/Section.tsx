import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { LazyFigure } from "./LazyFigure";
import { LESSONS } from "./lessons";
import { presenting, slide } from "./present";
import { SOURCES, type SourceName } from "./sources";

interface SectionProps {
  readonly id: string;
  readonly number: number;
  readonly title: string;
  readonly figure: ComponentChildren;
  /** The text before the figure, and after it. */
  readonly children: ComponentChildren;
  readonly after?: ComponentChildren;
  readonly sources: readonly (SourceName | readonly [SourceName, string])[];
}

/** Text sizes for a lecture hall, used on screens of at least WIDE pixels if the figure fits. */
const SMALLEST = "100%";
const TEXT_SIZES = ["125%", "112%", SMALLEST];
const WIDE = 1120;
/** Least width of a figure as a fraction of the available width: with large text, and with the smallest text. */
const NARROW = 0.6;
const NARROWEST = 0.5;

/** Sets the figure of a slide to the greatest width at which its height fits. */
function useFittedWidth(on: boolean) {
  const frame = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const element = frame.current;
    const room = element?.parentElement;
    if (!element || !room || !on) return;
    const page = document.documentElement.style;
    const settle = (): void => {
      const widest = room.clientWidth;
      for (const size of innerWidth < WIDE ? [SMALLEST] : TEXT_SIZES) {
        page.fontSize = size;
        const least = (size === SMALLEST ? NARROWEST : NARROW) * widest;
        for (let width = widest; width > least; width *= 0.97) {
          element.style.width = `${width}px`;
          if (element.offsetHeight <= room.clientHeight) return;
        }
      }
      element.style.width = `${widest}px`; // it scrolls within the slide
    };
    const observer = new ResizeObserver(settle);
    observer.observe(room);
    return () => {
      observer.disconnect();
      element.style.width = "";
      page.fontSize = "";
    };
  }, [on]);
  return frame;
}

/** One lesson: a heading, text, one interactive figure, and the sources. */
export function Section({ id, number, title, figure, children, after, sources }: SectionProps) {
  const onSlide = presenting.value && slide.value === number - 1;
  const frame = useFittedWidth(onSlide);
  return (
    <section
      class={`lesson${onSlide ? " on-slide" : ""}`}
      id={id}
      data-scene={id}
      aria-labelledby={`${id}-title`}
      hidden={presenting.value && !onSlide}
    >
      <h2 id={`${id}-title`}>
        <a class="lesson-number" href={`#${id}`} title="Link to this section">
          {number}
        </a>{" "}
        {title}
      </h2>
      <div class="prose">{children}</div>
      <div class="lesson-room">
        <div class="lesson-figure" ref={frame}>
          <LazyFigure now={onSlide} reserve={LESSONS[number - 1]?.reserve ?? [0, 0, 0]}>
            {figure}
          </LazyFigure>
        </div>
      </div>
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
        </footer>
      )}
    </section>
  );
}
