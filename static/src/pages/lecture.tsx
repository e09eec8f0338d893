import "../style/index.css";
import "./lecture/lecture.css";
import "./lecture/present/present.css";
import "./lecture/present/figures.css";
import { computed } from "@preact/signals";
import { type ComponentType, Fragment, render } from "preact";
import { useEffect, useLayoutEffect, useRef } from "preact/hooks";
import { fetchLater, isLater, later } from "../lessons/stage/later";
import { followedCode } from "../store/classroom";
import { ClassButton, ClassHost } from "../tools/classroom/ClassHost";
import { fetchAhead } from "../tools/classroom/fetchAhead";
import { Button } from "../ui/Button";
import { anchorScroll } from "../ui/browser/scrollAnchor";
import { SiteHeader } from "../ui/site/SiteHeader";
import { Toasts, toast } from "../ui/Toast";
import { renderNearFigures, showSection } from "./lecture/awaitedFigures";
import { LectureStage } from "./lecture/LectureStage";
import { LECTURE_PARTS, LESSONS, type Lesson, type LessonId, type Part, sectionOf } from "./lecture/lessons";
import { AlgorithmSection } from "./lecture/mapping/AlgorithmSection";
import { CellSection } from "./lecture/mapping/CellSection";
import { DigitsSection } from "./lecture/mapping/DigitsSection";
import { EndpointSection } from "./lecture/mapping/EndpointSection";
import { GridSection } from "./lecture/mapping/GridSection";
import { LandmarksSection } from "./lecture/mapping/LandmarksSection";
import { ModelSection } from "./lecture/mapping/ModelSection";
import { NoReturnSection } from "./lecture/mapping/NoReturnSection";
import { RaysSection } from "./lecture/mapping/RaysSection";
import { SonarSection } from "./lecture/mapping/SonarSection";
import { WindowSection } from "./lecture/mapping/WindowSection";
import { attendLecture, shownPointer } from "./lecture/present/classSlides";
import { OwnSlide } from "./lecture/present/OwnSlide";
import { Blank, Presenter, usePresentation } from "./lecture/present/Presenter";
import { SpeakerView } from "./lecture/present/SpeakerView";
import { fetchAnswers } from "./lecture/present/shownAnswers";
import {
  isPreview,
  presenting,
  readAddress,
  sectionInSight,
  sectionOfSlide,
  setPresenting,
  shownOf,
} from "./lecture/present/state";
import type { SectionHead } from "./lecture/Section";
import { SectionList } from "./lecture/SectionList";
import { FileSection } from "./lecture/using/FileSection";
import { OctreeSection, TerrainSection, TsdfSection } from "./lecture/using/In3dSections";
import { KidnappingSection, ParticlesSection, SensorModelsSection } from "./lecture/using/LocalizationSections";
import {
  InflationSection,
  LayersSection,
  LifetimeSection,
  PathSection,
  StackSection,
} from "./lecture/using/NavigationSections";
import { NextSection } from "./lecture/using/NextSection";
import { CountingSection } from "./lecture/wrong/CountingSection";
import { LowTableSection, PeopleSection, PolishedSection } from "./lecture/wrong/FailureSections";
import { ForgettingSection } from "./lecture/wrong/ForgettingSection";
import { GraphSection } from "./lecture/wrong/GraphSection";
import { MatchingSection } from "./lecture/wrong/MatchingSection";
import { MountSection } from "./lecture/wrong/MountSection";
import { OdometrySection } from "./lecture/wrong/OdometrySection";
import { ProbableSection } from "./lecture/wrong/ProbableSection";
import { ResolutionSection } from "./lecture/wrong/ResolutionSection";

/** The lecturer's pointer on a follower's slide. */
function ClassPointer() {
  const at = shownPointer.value;
  const box = at && document.querySelector(".slides > main")?.getBoundingClientRect();
  if (!at || !box) return null;
  // The position is in zoomed pixels of the slide, because the element is inside the zoomed page.
  const zoom = Number(document.documentElement.style.zoom) || 1;
  const [left, top] = [(box.x + at[0] * box.width) / zoom, (box.y + at[1] * box.height) / zoom];
  return <div class="class-pointer" aria-hidden="true" style={`left: ${left}px; top: ${top}px`} />;
}

/** Resolves when every font of the page has loaded or failed, at the latest after `ms` milliseconds. */
const fontsLoaded = (ms: number): Promise<unknown> =>
  Promise.race([
    Promise.allSettled([...document.fonts].map((font) => font.load())),
    new Promise((done) => setTimeout(done, ms)),
  ]);

interface PartHeadProps {
  /** Its position among the parts, from 1. */
  readonly number: number;
  readonly part: Part;
}

/** The heading of a part, with its sections. */
function PartHead({ number, part: { title, sentence, lessons } }: PartHeadProps) {
  return (
    <nav class="part-head no-print" aria-label={`Part ${number}: ${title}`}>
      <p class="part-number">Part {number}</p>
      <p class="part-title">{title}</p>
      <p>{sentence}</p>
      <ol start={(lessons[0]?.index ?? 0) + 1}>
        {lessons.map(({ id, title: name }) => (
          <li key={id}>
            <a href={`#${id}`}>{name}</a>
          </li>
        ))}
      </ol>
    </nav>
  );
}

interface Entry extends Lesson {
  readonly body: ComponentType<SectionHead>;
}

/** The body of each lesson, by its id. */
const BODIES: Record<LessonId, Entry["body"]> = {
  landmarks: LandmarksSection,
  grid: GridSection,
  cell: CellSection,
  "log-odds": DigitsSection,
  model: ModelSection,
  window: WindowSection,
  "no-return": NoReturnSection,
  endpoint: EndpointSection,
  rays: RaysSection,
  algorithm: AlgorithmSection,
  sonar: SonarSection,
  mount: MountSection,
  forgetting: ForgettingSection,
  counting: CountingSection,
  resolution: ResolutionSection,
  polished: PolishedSection,
  people: PeopleSection,
  "low-table": LowTableSection,
  odometry: OdometrySection,
  probable: ProbableSection,
  matching: MatchingSection,
  graph: GraphSection,
  file: FileSection,
  particles: ParticlesSection,
  "sensor-models": SensorModelsSection,
  kidnapping: KidnappingSection,
  layers: LayersSection,
  inflation: InflationSection,
  path: PathSection,
  lifetime: LifetimeSection,
  stack: StackSection,
  octree: OctreeSection,
  tsdf: TsdfSection,
  terrain: TerrainSection,
  next: NextSection,
};
const ENTRIES: readonly Entry[] = LESSONS.map((lesson) => ({ ...lesson, body: BODIES[lesson.id] }));
const FIRST_LATER = ENTRIES.findIndex(({ id }) => isLater(id));

/**
 * The sections on the page. Those from the first whose figure has not loaded are added once it has: the page grows only
 * at its end, so nothing in view moves.
 */
const entriesNow = computed(() => (later.value || presenting.value ? ENTRIES : ENTRIES.slice(0, FIRST_LATER)));
/** A picture of a slide has no other sections, so that it is ready sooner. */
const isOnPage = ({ id, index }: Part["lessons"][number]): boolean =>
  isPreview ? shownOf(id) !== null : index < entriesNow.value.length;

/**
 * Fonts that arrive after the first text is shown move it. They are smaller than the page's code and load at the same
 * time.
 */
const FONTS_MS = 1000;

/** Scroll to the section in the address, or show its slide, at the start and when the address changes. */
function useAddress(): void {
  useLayoutEffect(() => {
    const follow = (): void => {
      readAddress().catch((error: Error) => toast(`${error.message} The slides stay as they are.`, "error"));
      if (!presenting.peek()) showSection(sectionOf(location.hash.slice(1)));
    };
    follow(); // the sections were not yet rendered when the browser looked for the anchor
    addEventListener("hashchange", follow);
    return () => removeEventListener("hashchange", follow);
  }, []);
  const known = useRef(entriesNow.peek());
  const entries = entriesNow.value;
  useLayoutEffect(() => {
    const added = entries.slice(known.current.length).map(({ id }) => id as string);
    known.current = entries;
    const wanted = sectionOf(location.hash.slice(1));
    if (added.includes(wanted)) showSection(wanted);
  }, [entries]);
}

/** Keep the text that is being read in place while the figures are rendered. */
function useStillText() {
  const main = useRef<HTMLElement>(null);
  useLayoutEffect(() => (main.current ? anchorScroll(main.current, ".lesson > *, .prose > *") : undefined), []);
  const shown = presenting.value;
  const entries = entriesNow.value;
  useLayoutEffect(renderNearFigures, [shown, entries]);
  return main;
}

/** At the end of the presentation mode, scroll to the section of the last slide. */
function useReturn(): void {
  const was = useRef(presenting.peek());
  const now = presenting.value;
  useEffect(() => {
    if (was.current && !now) showSection(sectionOfSlide());
    was.current = now;
  }, [now]);
}

/** Start the presentation at the section in view. */
const present = (): void => setPresenting(true, ENTRIES[sectionInSight(ENTRIES)]?.id as LessonId | undefined);

function Page() {
  usePresentation();
  useAddress();
  useReturn();
  const main = useStillText();
  return (
    <>
      {presenting.value ? (
        <Presenter />
      ) : (
        <SiteHeader current="lecture" links={followedCode === null}>
          <ClassButton />
        </SiteHeader>
      )}
      {!presenting.value && <SectionList />}
      <div class={presenting.value ? "slides" : "lecture-with-stage"}>
        {!presenting.value && <LectureStage />}
        <main class="lecture" id="main" tabIndex={-1} ref={main}>
          {!presenting.value && (
            <div class="lecture-head">
              <h1>Occupancy grid mapping</h1>
              <p class="prose">
                How a robot makes a map from measured distances, and how it uses that map.{" "}
                <span class="no-print">
                  Drag the coloured parts of the figures, and <span class="drag-number-sample">underlined</span>{" "}
                  numbers. The large map beside the text is the <b>stage</b>: it follows what you read.
                </span>
              </p>
              <div class="actions no-print">
                <Button icon="fit" onClick={present}>
                  Presentation mode
                </Button>
                <Button href="/lab.html">Open the lab</Button>
              </div>
            </div>
          )}
          {LECTURE_PARTS.map((part, i) => (
            <Fragment key={part.title}>
              {!presenting.value && part.lessons.some(isOnPage) && <PartHead number={i + 1} part={part} />}
              {part.lessons.filter(isOnPage).map(({ id, title, index }) => {
                const Body = BODIES[id];
                return <Body key={id} id={id} number={index + 1} title={title} />;
              })}
            </Fragment>
          ))}
          <OwnSlide />
        </main>
      </div>
      <Blank />
      <ClassPointer />
      {!isPreview && <ClassHost />}
      <Toasts meanwhile="The lecture works without it; a class continues as soon as it answers." />
    </>
  );
}

const speaker = new URLSearchParams(location.search).get("speaker");
void fetchLater(async () => (await import("../lessons/later")).LATER);
void fetchAnswers();
// The lecturer may show a slide with the lab, which is another page of a follower.
if (followedCode !== null) addEventListener("load", () => void fetchAhead(`/class/${followedCode}/lab.html`));
if (speaker === null && !isPreview) attendLecture(ENTRIES);
await fontsLoaded(FONTS_MS);
render(speaker === null ? <Page /> : <SpeakerView channel={speaker} />, document.getElementById("app") as HTMLElement);
