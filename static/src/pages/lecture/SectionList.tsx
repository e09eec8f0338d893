import { useSignal } from "@preact/signals";
import { useEffect, useId, useRef } from "preact/hooks";
import { onScroll } from "../../ui/browser/scrollAnchor";
import { Icon } from "../../ui/Icon";
import { LECTURE_PARTS, LESSONS } from "./lessons";
import { sectionInSight } from "./present/state";
import "./sectionList.css";

/** The list of sections in a bar that unfolds, with the visible section marked. */
export function SectionList() {
  const id = useId();
  const root = useRef<HTMLElement>(null);
  const here = useSignal(-1);
  const open = useSignal(false);
  useEffect(() => {
    const end = onScroll(() => {
      here.value = sectionInSight(LESSONS);
    });
    const stop = new AbortController();
    const away = (event: Event): void => {
      if (!root.current?.contains(event.target as Node)) open.value = false;
    };
    addEventListener("pointerdown", away, { signal: stop.signal });
    addEventListener("focusin", away, { signal: stop.signal });
    return () => {
      end();
      stop.abort();
    };
  }, [here, open]);
  const now = LESSONS[here.value];
  return (
    <nav
      class={`section-list no-print${open.value ? " open" : ""}`}
      ref={root}
      aria-label="Sections of the lecture"
      onKeyDown={(event) => {
        if (event.key !== "Escape" || !open.value) return;
        open.value = false;
        root.current?.querySelector("button")?.focus();
      }}
    >
      <button
        type="button"
        aria-expanded={open.value}
        aria-controls={id}
        onClick={() => {
          open.value = !open.value;
        }}
      >
        <span class="section-list-word">Sections</span>
        <span class="section-list-now">{now ? `${here.value + 1} ${now.title}` : ""}</span>
        <Icon name="unfold" />
      </button>
      <div class="section-list-parts" id={id}>
        {LECTURE_PARTS.map(({ title: part, lessons }) => (
          <section key={part} aria-label={part}>
            <p>{part}</p>
            <ol>
              {lessons.map(({ id: anchor, title, index }) => (
                <li key={anchor}>
                  <a
                    href={`#${anchor}`}
                    {...(index === here.value ? { "aria-current": "location" as const } : {})}
                    onClick={() => {
                      open.value = false;
                    }}
                  >
                    <span class="section-list-number">{index + 1}</span> {title}
                  </a>
                </li>
              ))}
            </ol>
          </section>
        ))}
      </div>
    </nav>
  );
}
