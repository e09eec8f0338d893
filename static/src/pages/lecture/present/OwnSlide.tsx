import "./ownSlide.css";
import { computed, useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { useSeen, useSteps } from "../../../lessons/common/useSteps";
import { DRIVE } from "../../../lessons/stage/floor";
import { scene } from "../../../lessons/stage/scene";
import { WorldStage } from "../../../lessons/stage/WorldStage";
import { listenToPage, pagesInSlides } from "../../../tools/classroom/pageInSlide";
import { reducedMotion } from "../../../ui/browser/media";
import { printing } from "../../../ui/browser/theme";
import { act, canAct } from "./acts";
import type { PageSlide, Slide } from "./deck/deck";
import { listenToKeys } from "./keys";
import { isPreview, paragraphsOf, place, presenting, slide, slides, stepped } from "./state";

interface FormulaPart {
  readonly text: string;
  readonly place: "line" | "sub" | "sup";
}

const PART = /([_^])(?:\{([^{}]*)\}|(\S))|([^_^]+|[_^])/gu;

/**
 * The formula of a line between two dollar signs such as `$p_t = 1 - e^{-x}$`, with indices and exponents as in LaTeX;
 * null if the line is not a formula.
 */
export function formulaOf(line: string): readonly FormulaPart[] | null {
  const inside = /^\s*\$(.+)\$\s*$/u.exec(line)?.[1];
  if (!inside) return null;
  return [...inside.matchAll(PART)].map(([, mark, braced, single, plain]) =>
    mark
      ? { text: (braced ?? single ?? "").replaceAll("-", "−"), place: mark === "_" ? "sub" : "sup" }
      : { text: (plain ?? "").replaceAll("-", "−"), place: "line" },
  );
}

const MS = 180;

/** The map of the lecture's drive, which fills in scan by scan. With reduced motion and in a preview it is complete. */
function TitleMap() {
  const root = useRef<HTMLDivElement>(null);
  const isStill = reducedMotion.peek() || isPreview;
  const count = useSignal(isStill ? DRIVE.length : 1);
  const playing = useSignal(!isStill);
  const now = useMemo(
    () =>
      computed(() =>
        scene({
          scans: count.value,
          marks: ["beams"],
          caption: `The map after ${count.value} of ${DRIVE.length} scans.`,
        }),
      ),
    [count],
  );
  useSteps(
    playing,
    useSeen(root),
    () => MS,
    () => {
      count.value = Math.min(DRIVE.length, count.peek() + 1);
      playing.value = count.peek() < DRIVE.length;
    },
  );
  return (
    <div class="title-map" ref={root}>
      <WorldStage scene={now} still={printing.value} />
    </div>
  );
}

/** Single letters are variables, in italics; digits, brackets and function names are upright. */
function Letters({ text }: { readonly text: string }) {
  const runs = text.split(/(?<!\p{L})(\p{L})(?!\p{L})/u);
  return <>{runs.map((run, i) => (i % 2 === 1 ? <i key={`${i} ${run}`}>{run}</i> : run))}</>;
}

function Formula({ parts }: { readonly parts: readonly FormulaPart[] }) {
  return (
    <span class="own-formula">
      {parts.map(({ text, place: where }, i) => {
        const key = `${i} ${text}`;
        if (where === "sub")
          return (
            <sub key={key}>
              <Letters text={text} />
            </sub>
          );
        return where === "sup" ? (
          <sup key={key}>
            <Letters text={text} />
          </sup>
        ) : (
          <Letters key={key} text={text} />
        );
      })}
    </span>
  );
}

/** Lines that begin with a dash form a list, lines between dollar signs are formulas. */
function Paragraph({ text, shown }: { text: string; shown: boolean }) {
  const lines = text.split("\n").filter((line) => line.trim());
  const isList = lines.every((line) => /^\s*[-–•] /.test(line));
  const style = { visibility: shown ? "visible" : "hidden" } as const;
  if (!isList)
    return (
      <p style={style}>
        {lines.map((line, i) => {
          const parts = formulaOf(line);
          return parts ? <Formula key={`${i} ${line}`} parts={parts} /> : `${line}\n`;
        })}
      </p>
    );
  return (
    <ul style={style}>
      {lines.map((line) => (
        <li key={line}>{line.replace(/^\s*[-–•] /, "")}</li>
      ))}
    </ul>
  );
}

/** How long to wait for a lab that has loaded but has not reported. */
const LONGEST_START_MS = 30_000;

/** A page of this service inside the slide. Its window forwards the keys of the presentation. */
function Framed({ kind, address, title }: PageSlide) {
  const frame = useRef<HTMLIFrameElement>(null);
  const isLoaded = useSignal(false);
  const isLate = useSignal(false);
  const said = pagesInSlides.value.get(address);
  const isStarting = kind === "lab" && !isLate.value && !said?.show && !said?.note;
  useEffect(() => {
    if (!isLoaded.value) return;
    const timer = setTimeout(() => {
      isLate.value = true;
    }, LONGEST_START_MS);
    return () => clearTimeout(timer);
  }, [isLoaded.value, isLate]);
  useEffect(() => {
    let stop = (): void => {};
    const listen = (): void => {
      stop();
      isLoaded.value = true;
      const inside = frame.current?.contentWindow;
      if (inside) stop = listenToKeys(inside, act, canAct);
    };
    const element = frame.current;
    if (!element) return;
    element.addEventListener("load", listen);
    const stopPage = listenToPage(element, address);
    return () => {
      element.removeEventListener("load", listen);
      stopPage();
      stop();
    };
  }, [address, isLoaded]);
  if (!address) return <p class="slide-frame-place">This page is on the lecturer’s screen.</p>;
  if (isPreview) return <p class="slide-frame-place">{address.split(/[?#]/)[0]}</p>;
  const isAwaited = !isLoaded.value || isStarting;
  return (
    <>
      <iframe class={`slide-frame ${isAwaited ? "is-awaited" : ""}`} src={address} title={title} ref={frame} />
      {isAwaited && (
        <p class="slide-frame-place" role="status">
          Loading the {kind === "lab" ? "lab" : "map"} …
        </p>
      )}
    </>
  );
}

interface PageSlideProps {
  readonly of: PageSlide;
  /** Whether it is the present slide; otherwise it is the next one, out of view. */
  readonly isNow: boolean;
}

/** A slide with a page of this service, loaded while the previous slide is shown because that takes a second. */
function PageOfSlide({ of, isNow }: PageSlideProps) {
  const { kind, title } = of;
  return (
    <section class={`own-slide own-${kind} ${isNow ? "on-slide" : "is-next"}`} aria-label={title} inert={!isNow}>
      <Framed {...of} />
    </section>
  );
}

const isPage = (of: Slide): of is PageSlide => of.kind === "lab" || of.kind === "log";

/** The present slide if it is not from the lecture, and the page of the next one. */
export function OwnSlide() {
  if (!presenting.value) return null;
  const now = slide.value;
  const { index } = place.value;
  const next = isPreview ? index : stepped(place.value, 1, true, slides.value).index;
  return (
    <>
      {now?.kind === "title" && (
        <section class="own-slide own-title on-slide" aria-label={now.title}>
          <TitleMap />
        </section>
      )}
      {now?.kind === "text" && (
        <section class="own-slide own-text on-slide" aria-label={now.title}>
          <h2 class="visually-hidden">{now.title}</h2>
          <div class="own-text-page">
            {paragraphsOf(now.text).map((text, i) => (
              <Paragraph key={`${i} ${text}`} text={text} shown={i <= place.value.step} />
            ))}
          </div>
        </section>
      )}
      {slides.value.map((shown, i) =>
        isPage(shown) && (i === index || i === next) ? (
          <PageOfSlide key={`${i} ${shown.address}`} of={shown} isNow={i === index} />
        ) : null,
      )}
    </>
  );
}
