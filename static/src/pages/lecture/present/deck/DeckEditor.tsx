import { type Signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { Button } from "../../../../ui/Button";
import { OpenFiles } from "../../../../ui/files/OpenFiles";
import { saveAs } from "../../../../ui/files/saveAs";
import { Icon } from "../../../../ui/Icon";
import { toast } from "../../../../ui/Toast";
import { LECTURE_PARTS, type LessonId } from "../../lessons";
import { changeDeck, deck, deckLink, place, takeDeck } from "../state";
import { type Deck, LONGEST_TITLE, readDeckFile, type Slide, titleOf, WHOLE_LECTURE, writtenDeck } from "./deck";
import {
  allShown,
  gapAt,
  hasPart,
  indexAfter,
  keyedIndex,
  numberOf,
  only,
  onlyPart,
  reordered,
  shown,
} from "./deckOrder";
import { type OwnSlide, SlideForm } from "./SlideForm";
import { LargePicture, Thumbnail, ThumbnailMaker } from "./Thumbnail";
import "./deckEditor.css";

type Planned = readonly [slide: LessonId | "cell-derivation" | "title", minutes: number];

/** Filter, sensor model and traversal, then the faults, and the use of the map. */
const PLANNED: readonly Planned[] = [
  ["title", 1],
  ["grid", 2],
  ["cell", 3],
  ["cell-derivation", 4],
  ["log-odds", 2],
  ["model", 4],
  ["window", 2],
  ["rays", 4],
  ["algorithm", 3],
  ["no-return", 2],
  ["mount", 2],
  ["people", 2],
  ["odometry", 3],
  ["file", 2],
  ["path", 3],
  ["stack", 1],
  ["next", 1],
];
/** Comes after the algorithm. */
const LOG: Slide = { kind: "log", title: "The map of a real log", address: "/logs.html", minutes: 4 };

const nameOf = (slide: Slide): string =>
  slide.kind === "section" ? slide.section : slide.kind === "derivation" ? `${slide.section}-derivation` : slide.kind;

const minutesOf = new Map<string, number>(PLANNED);

export const SHORT_LECTURE: Deck = {
  title: `${WHOLE_LECTURE.title} in 45 minutes`,
  slides: WHOLE_LECTURE.slides.flatMap((slide): Slide[] => {
    const name = nameOf(slide);
    const minutes = minutesOf.get(name);
    const now = minutes === undefined ? { ...slide, hidden: true } : { ...slide, minutes };
    return name === "algorithm" ? [now, LOG] : [now];
  }),
};

const KIND_NAMES = {
  title: "title",
  section: "",
  derivation: "derivation",
  text: "own text",
  lab: "lab",
  log: "log",
} as const;

/** A dragged row, and the gap where it would be inserted: 0 above the first row. */
export interface Drag {
  readonly from: number;
  readonly gap: number;
}

interface DeckRowProps {
  readonly slide: Slide;
  readonly index: number;
  /** Whether each slide is shown. */
  readonly isShown: readonly boolean[];
  /** Whether it is the last row of the list. */
  readonly isLast: boolean;
  readonly drag: Signal<Drag | null>;
  /** The index of the slide whose form is open, −1 for none. */
  readonly edited: Signal<number>;
  readonly onMove: (to: number) => void;
  /** Replaces the slide; null removes it. */
  readonly onChange: (slide: Slide | null) => void;
  readonly onLook: () => void;
}

const rowsOf = (grip: HTMLElement): HTMLElement[] =>
  [...(grip.closest("ol")?.children ?? [])].filter((row): row is HTMLElement => row instanceof HTMLElement);

/** The part of the dialog that scrolls. */
const BODY = ".deck-body";
/** Distance from its edge at which a dragged row scrolls it, and the scroll per move. Pixels. */
const EDGE = 36;
const SCROLL = 14;

/** One slide in the list of the deck. */
function DeckRow({ slide, index, isShown, isLast, drag, edited, onMove, onChange, onLook }: DeckRowProps) {
  const title = titleOf(slide);
  const own: OwnSlide | null = "section" in slide ? null : slide;
  const held = drag.value;
  const count = isShown.length;
  const up = keyedIndex("ArrowUp", index, isShown) ?? index;
  const down = keyedIndex("ArrowDown", index, isShown) ?? index;
  const hide = (): void => onChange(slide.hidden ? shown(slide) : { ...slide, hidden: true });
  const take = (event: PointerEvent): void => {
    if (event.button !== 0) return;
    (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId);
    drag.value = { from: index, gap: index };
  };
  const carry = (event: PointerEvent): void => {
    if (!drag.peek()) return;
    const grip = event.currentTarget as HTMLElement;
    const body = grip.closest(BODY);
    if (body) {
      const { top, bottom } = body.getBoundingClientRect();
      if (event.clientY < top + EDGE) body.scrollTop -= SCROLL;
      if (event.clientY > bottom - EDGE) body.scrollTop += SCROLL;
    }
    const gap = gapAt(
      event.clientY,
      rowsOf(grip).map((row) => row.getBoundingClientRect()),
    );
    drag.value = { from: index, gap };
  };
  const drop = (): void => {
    const now = drag.peek();
    drag.value = null;
    if (now && indexAfter(now.from, now.gap) !== now.from) onMove(indexAfter(now.from, now.gap));
  };
  const marks = [
    slide.hidden && "is-hidden",
    held?.from === index && "is-dragged",
    held?.gap === index && "takes-before",
    held?.gap === count && isLast && "takes-after",
  ].filter(Boolean);
  return (
    <li class={["deck-row", ...marks].join(" ")} onPointerEnter={onLook} onFocusCapture={onLook}>
      <button
        type="button"
        class="deck-grip"
        aria-label={`Place of “${title}”: arrow keys move it`}
        title="Drag, or move with the arrow keys"
        onPointerDown={take}
        onPointerMove={carry}
        onPointerUp={drop}
        onPointerCancel={() => {
          drag.value = null;
        }}
        onKeyDown={(event) => {
          const to = keyedIndex(event.key, index, isShown);
          if (to === null) return;
          event.preventDefault();
          onMove(to);
        }}
      >
        <Icon name="grip" />
      </button>
      <span class="deck-row-number">{slide.hidden ? "" : numberOf(isShown, index)}</span>
      <Thumbnail slide={slide} />
      <span class="deck-row-title">
        {title}
        {own && <small> {KIND_NAMES[slide.kind]}</small>}
        {slide.hidden && <small> hidden</small>}
      </span>
      <Button kind="quiet" icon="up" label={`Move “${title}” up`} disabled={up === index} onClick={() => onMove(up)} />
      <Button
        kind="quiet"
        icon="unfold"
        label={`Move “${title}” down`}
        disabled={down === index}
        onClick={() => onMove(down)}
      />
      <Button
        kind="quiet"
        icon={slide.hidden ? "hidden" : "shown"}
        label={`${slide.hidden ? "Show" : "Hide"} “${title}”`}
        onClick={hide}
      />
      {own ? (
        <Button
          kind="quiet"
          icon="pen"
          label={`Edit “${title}”`}
          pressed={edited.value === index}
          onClick={() => {
            edited.value = edited.peek() === index ? -1 : index;
          }}
        />
      ) : (
        <span />
      )}
      {own && edited.value === index && (
        <>
          <SlideForm slide={own} button="Save the slide" onSave={onChange} />
          <Button icon="trash" kind="danger" disabled={count === 1} onClick={() => onChange(null)}>
            Remove this slide
          </Button>
        </>
      )}
    </li>
  );
}

/** Change the slides. The present slide, at `index`, stays if it still exists. */
async function change(
  slides: readonly Slide[],
  index = slides.indexOf(deck.peek().slides[place.peek().index] as Slide),
): Promise<void> {
  const title = deck.peek() === WHOLE_LECTURE ? `${WHOLE_LECTURE.title}, my deck` : deck.peek().title;
  await changeDeck({ title, slides }, index >= 0 ? { index, step: place.peek().step } : undefined);
}

/** Time that the pointer rests on a row before its picture is shown, ms, because it passes over many. */
const REST_MS = 150;

/** The list of slides, and a picture of the selected one. */
function Slides() {
  const { slides } = deck.value;
  const list = useRef<HTMLOListElement>(null);
  const timer = useRef<ReturnType<typeof setTimeout> | undefined>(undefined);
  const drag = useSignal<Drag | null>(null);
  const edited = useSignal(-1);
  const atHand = useSignal(place.peek().index);
  const said = useSignal("");
  const onlyShown = useSignal(false);
  useEffect(() => {
    const frame = requestAnimationFrame(() => {
      // When the dialog is open: rows have no positions before.
      list.current?.children[place.peek().index]?.scrollIntoView({ block: "center" });
    });
    return () => {
      cancelAnimationFrame(frame);
      clearTimeout(timer.current);
    };
  }, []);
  const isShown = slides.map((slide) => !slide.hidden);
  const count = isShown.filter(Boolean).length;
  const present = place.value.index;
  const lastRow = onlyShown.value ? isShown.lastIndexOf(true) : slides.length - 1;
  const shown = Math.min(atHand.value, slides.length - 1);
  const atHandSlide = slides[shown] as Slide;
  const title = titleOf(atHandSlide);
  const move = async (from: number, to: number): Promise<void> => {
    await change(reordered(slides, from, to));
    edited.value = -1;
    atHand.value = to;
    said.value = `“${titleOf(slides[from] as Slide)}” is slide ${to + 1} of ${slides.length}.`;
    requestAnimationFrame(() => list.current?.querySelectorAll<HTMLElement>(".deck-grip")[to]?.focus());
  };
  const replace = (index: number, slide: Slide | null): void => {
    const next = slides.flatMap((kept, i) => (i !== index ? [kept] : slide ? [slide] : []));
    if (next.every((slide) => slide.hidden)) toast("One slide has to stay.", "error");
    else {
      void change(next);
      edited.value = -1;
    }
  };
  return (
    <div class="deck-slides">
      <div class="deck-choice">
        <p>
          {count} of {slides.length} slides are shown
        </p>
        <div class="actions">
          <Button
            disabled={count === 1 && isShown[present] === true}
            onClick={() =>
              void change(
                only(slides, (_, i) => i === present),
                present,
              )
            }
          >
            Hide all but the present slide
          </Button>
          {LECTURE_PARTS.map((part, i) => (
            <Button
              key={part.title}
              disabled={!hasPart(slides, part)}
              onClick={() => void change(onlyPart(slides, part))}
            >
              Part {i + 1} only
            </Button>
          ))}
          <Button disabled={count === slides.length} onClick={() => void change(allShown(slides), present)}>
            Show all
          </Button>
          <Button
            pressed={onlyShown.value}
            onClick={() => {
              onlyShown.value = !onlyShown.peek();
            }}
          >
            List only the shown ones
          </Button>
        </div>
      </div>
      <ol class={`deck-list ${onlyShown.value ? "only-shown" : ""}`} ref={list}>
        {slides.map((slide, i) => (
          <DeckRow
            key={`${titleOf(slide)} ${i}`}
            slide={slide}
            index={i}
            isShown={isShown}
            isLast={i === lastRow}
            drag={drag}
            edited={edited}
            onMove={(to) => void move(i, to)}
            onChange={(next) => replace(i, next)}
            onLook={() => {
              clearTimeout(timer.current);
              timer.current = setTimeout(() => {
                atHand.value = i;
              }, REST_MS);
            }}
          />
        ))}
      </ol>
      <ThumbnailMaker />
      <figure class="deck-picture">
        <LargePicture slide={atHandSlide} index={shown} />
        <figcaption>{isShown[shown] ? `${numberOf(isShown, shown)}: ${title}` : `${title} (hidden)`}</figcaption>
      </figure>
      <p class="visually-hidden" role="status">
        {said.value}
      </p>
    </div>
  );
}

function save(of: Deck): void {
  const blob = new Blob([JSON.stringify(writtenDeck(of), null, 2)], { type: "application/json" });
  saveAs(`${of.title.replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-|-$/g, "") || "deck"}.json`, blob);
}

async function copyLink(of: Deck): Promise<void> {
  const link = await deckLink(of);
  try {
    await navigator.clipboard.writeText(link);
    toast("The link is copied. It holds the whole deck, with its notes and hidden slides.");
  } catch {
    window.prompt("The link of the deck:", link);
  }
}

/** The dialog in which the lecturer arranges slides, adds new ones, and saves the deck as a file or a link. */
export function DeckEditor({ onClose }: { readonly onClose: () => void }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const body = useRef<HTMLDivElement>(null);
  const problem = useSignal("");
  useEffect(() => dialog.current?.showModal(), []);
  const { title } = deck.value;
  const add = async (slide: Slide): Promise<void> => {
    await change([...deck.peek().slides, slide]);
    requestAnimationFrame(() => body.current?.scrollTo({ top: body.current.scrollHeight }));
  };
  const load = async (chosen: File): Promise<void> => {
    problem.value = "";
    try {
      await takeDeck(readDeckFile(await chosen.text()));
      toast(`“${chosen.name}” is loaded.`);
    } catch (error) {
      problem.value = `“${chosen.name}” was not loaded. ${(error as Error).message}`;
    }
  };
  return (
    <dialog ref={dialog} class="dialog deck-dialog" aria-labelledby="deck-title" onClose={onClose}>
      <div class="deck-head">
        <h2 id="deck-title">The slides</h2>
        <Button icon="close" kind="quiet" label="Close" onClick={() => dialog.current?.close()} />
      </div>
      <div class="deck-body" ref={body}>
        <label class="deck-name">
          <span>Name of the deck</span>
          <input
            class="field-text"
            type="text"
            value={title}
            maxLength={LONGEST_TITLE}
            onChange={({ currentTarget }) => {
              const name = currentTarget.value.trim();
              if (name) void changeDeck({ ...deck.peek(), title: name }, place.peek());
              else currentTarget.value = title;
            }}
          />
        </label>
        <details class="deck-add">
          <summary>
            <Icon name="plus" /> Add a slide
          </summary>
          <SlideForm button="Add at the end" onSave={(slide) => void add(slide)} />
        </details>
        <Slides />
      </div>
      <p class="deck-problem" role="alert">
        {problem.value}
      </p>
      <div class="actions">
        <Button icon="link" onClick={() => void copyLink(deck.peek())}>
          Copy link
        </Button>
        <Button icon="download" onClick={() => save(deck.peek())}>
          Save as file
        </Button>
        <OpenFiles label="File of a deck" accept="application/json,.json" onFiles={([chosen]) => void load(chosen)}>
          Load file
        </OpenFiles>
        <Button icon="restart" disabled={deck.value === WHOLE_LECTURE} onClick={() => void takeDeck(WHOLE_LECTURE)}>
          Whole lecture
        </Button>
        <Button icon="slides" disabled={deck.value === SHORT_LECTURE} onClick={() => void takeDeck(SHORT_LECTURE)}>
          45 minutes
        </Button>
      </div>
    </dialog>
  );
}
