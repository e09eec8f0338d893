import "./deckEditor.css";
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { Button } from "../../../ui/Button";
import { toast } from "../../../ui/Toast";
import { AddSlide } from "./AddSlide";
import { type Deck, LONGEST_TITLE, readDeckFile, type Slide, titleOf, WHOLE_LECTURE, writtenDeck } from "./deck";
import { deck, deckLink, place, takeDeck } from "./state";

const KIND_NAMES = { section: "", derivation: "derivation", text: "own text", lab: "lab", log: "log" } as const;

/** Change the slides; the present slide stays, where it still is there. */
function change(slides: readonly Slide[]): void {
  const now = deck.peek().slides[place.peek().index];
  const index = now ? slides.indexOf(now) : -1;
  const title = deck.peek() === WHOLE_LECTURE ? `${WHOLE_LECTURE.title}, my deck` : deck.peek().title;
  void takeDeck({ title, slides }, index >= 0 ? { index, step: place.peek().step } : undefined);
}

function moved(slides: readonly Slide[], from: number, by: 1 | -1): readonly Slide[] {
  const next = [...slides];
  const [one] = next.splice(from, 1);
  if (one) next.splice(from + by, 0, one);
  return next;
}

function Row({ slide, index, last }: { slide: Slide; index: number; last: boolean }) {
  const { slides } = deck.value;
  const title = titleOf(slide);
  const isOwn = !("section" in slide);
  const hide = (): void => {
    const { hidden, ...rest } = slide;
    const next = slides.map((one, i) => (i === index ? (hidden ? (rest as Slide) : { ...slide, hidden: true }) : one));
    if (next.every((one) => one.hidden)) toast("One slide has to stay.", "error");
    else change(next);
  };
  return (
    <li class={`deck-row${slide.hidden ? " is-hidden" : ""}`}>
      <span class="deck-row-number">{index + 1}</span>
      <span class="deck-row-title">
        {title}
        {KIND_NAMES[slide.kind] && isOwn && <small> {KIND_NAMES[slide.kind]}</small>}
        {slide.hidden && <small> hidden</small>}
      </span>
      <Button
        kind="quiet"
        icon="up"
        label={`Move “${title}” up`}
        disabled={index === 0}
        onClick={() => change(moved(slides, index, -1))}
      />
      <Button
        kind="quiet"
        icon="unfold"
        label={`Move “${title}” down`}
        disabled={last}
        onClick={() => change(moved(slides, index, 1))}
      />
      <Button
        kind="quiet"
        icon={slide.hidden ? "hidden" : "shown"}
        label={`${slide.hidden ? "Show" : "Hide"} “${title}”`}
        onClick={hide}
      />
      <Button
        kind="quiet"
        icon="trash"
        label={isOwn ? `Remove “${title}”` : "Slides of the lecture can be hidden, not removed"}
        disabled={!isOwn || slides.length === 1}
        onClick={() => change(slides.filter((_, i) => i !== index))}
      />
    </li>
  );
}

function save(of: Deck): void {
  const blob = new Blob([JSON.stringify(writtenDeck(of), null, 2)], { type: "application/json" });
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = `${of.title.replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-|-$/g, "") || "deck"}.json`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

async function copyLink(of: Deck): Promise<void> {
  const link = await deckLink(of);
  try {
    await navigator.clipboard.writeText(link);
    toast("The link is copied. It holds the whole deck.");
  } catch {
    window.prompt("The link of the deck:", link);
  }
}

/** The dialog in which the lecturer arranges the slides, adds own ones, and keeps the deck as a file or a link. */
export function DeckEditor({ onClose }: { readonly onClose: () => void }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const file = useRef<HTMLInputElement>(null);
  const problem = useSignal("");
  useEffect(() => dialog.current?.showModal(), []);
  const { title, slides } = deck.value;
  const load = async (chosen: File | undefined): Promise<void> => {
    if (!chosen) return;
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
      <header class="deck-head">
        <h2 id="deck-title">The slides</h2>
        <Button icon="close" kind="quiet" label="Close" onClick={() => dialog.current?.close()} />
      </header>
      <label class="deck-name">
        <span>Name of the deck</span>
        <input
          type="text"
          value={title}
          maxLength={LONGEST_TITLE}
          onChange={({ currentTarget }) => {
            const name = currentTarget.value.trim();
            if (name) void takeDeck({ ...deck.peek(), title: name }, place.peek());
            else currentTarget.value = title;
          }}
        />
      </label>
      <ol class="deck-list">
        {slides.map((slide, i) => (
          <Row key={`${titleOf(slide)} ${i}`} slide={slide} index={i} last={i === slides.length - 1} />
        ))}
      </ol>
      <AddSlide onAdd={(slide) => change([...deck.peek().slides, slide])} />
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
        <Button icon="upload" onClick={() => file.current?.click()}>
          Load file
        </Button>
        <Button icon="restart" disabled={deck.value === WHOLE_LECTURE} onClick={() => void takeDeck(WHOLE_LECTURE)}>
          Whole lecture
        </Button>
        <input
          ref={file}
          class="visually-hidden"
          type="file"
          accept="application/json,.json"
          tabIndex={-1}
          aria-label="File of a deck"
          onChange={({ currentTarget }) => {
            void load(currentTarget.files?.[0]);
            currentTarget.value = "";
          }}
        />
      </div>
    </dialog>
  );
}
