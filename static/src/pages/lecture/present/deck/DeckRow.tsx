import type { Signal } from "@preact/signals";
import { Button } from "../../../../ui/Button";
import { Icon } from "../../../../ui/Icon";
import { type Slide, titleOf } from "./deck";
import { gapAt, indexAfter, keyedIndex, numberOf, shown } from "./deckOrder";
import { type OwnSlide, SlideForm } from "./SlideForm";
import { Thumbnail } from "./Thumbnail";

const KIND_NAMES = {
  title: "title",
  section: "",
  derivation: "derivation",
  text: "own text",
  lab: "lab",
  log: "log",
} as const;

/** A row that is dragged, and the gap that it would go into: 0 above the first row. */
export interface Drag {
  readonly from: number;
  readonly gap: number;
}

interface DeckRowProps {
  readonly slide: Slide;
  readonly index: number;
  /** Whether each of the slides is shown. */
  readonly isShown: readonly boolean[];
  /** Whether it is the last row of the list. */
  readonly isLast: boolean;
  readonly drag: Signal<Drag | null>;
  /** The index of the slide whose form is open, −1 for none. */
  readonly edited: Signal<number>;
  readonly onMove: (to: number) => void;
  /** The slide is another one now; null: it goes. */
  readonly onChange: (slide: Slide | null) => void;
  readonly onLook: () => void;
}

const rowsOf = (grip: HTMLElement): HTMLElement[] =>
  [...(grip.closest("ol")?.children ?? [])].filter((row): row is HTMLElement => row instanceof HTMLElement);

/** How close to the edge of the list a dragged row makes it scroll, and by how much with each move. Pixels. */
const EDGE = 36;
const SCROLL = 14;

/** One slide in the list of the deck. */
export function DeckRow({ slide, index, isShown, isLast, drag, edited, onMove, onChange, onLook }: DeckRowProps) {
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
    const list = grip.closest("ol");
    if (list) {
      const { top, bottom } = list.getBoundingClientRect();
      if (event.clientY < top + EDGE) list.scrollTop -= SCROLL;
      if (event.clientY > bottom - EDGE) list.scrollTop += SCROLL;
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
