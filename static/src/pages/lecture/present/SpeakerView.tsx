import "./speaker.css";
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { Button } from "../../../ui/Button";
import { SlidePicture } from "./deck/SlidePicture";
import { type Act, listenToKeys } from "./keys";
import { followSlides, type Told } from "./sync";

const two = (value: number): string => String(value).padStart(2, "0");

/** Time of day, and since the window was opened or the watch was reset. */
function Watch() {
  const now = useSignal(Date.now());
  const since = useSignal(Date.now());
  useEffect(() => {
    const timer = setInterval(() => {
      now.value = Date.now();
    }, 500);
    return () => clearInterval(timer);
  }, [now]);
  const seconds = Math.max(0, Math.floor((now.value - since.value) / 1000));
  const clock = new Date(now.value);
  return (
    <div class="speaker-watch">
      <p>
        <span class="speaker-time number" role="timer">
          {Math.floor(seconds / 60)}:{two(seconds % 60)}
        </span>{" "}
        since the start · it is{" "}
        <span class="number">
          {two(clock.getHours())}:{two(clock.getMinutes())}
        </span>
      </p>
      <Button
        icon="restart"
        label="Restart the clock"
        onClick={() => {
          since.value = Date.now();
          now.value = Date.now();
        }}
      />
    </div>
  );
}

/** The speaker's window: the present slide, what the next step shows, and the notes. It controls the slides. */
export function SpeakerView({ channel }: { readonly channel: string }) {
  const told = useSignal<Told | null>(null);
  const send = useRef<(act: Act) => void>(() => {});
  useEffect(() => {
    document.title = "Speaker · Gridbloom";
    send.current = followSlides(channel, (next) => {
      told.value = next;
    });
    return listenToKeys(
      window,
      (act) => act !== "exit" && send.current(act),
      () => true,
    );
  }, [channel, told]);
  const now = told.value;
  if (!now)
    return (
      <main class="speaker">
        <h1>Waiting for the slides</h1>
        <p>
          This window follows the window of the slides that opened it. If that window was closed, close this one too.
        </p>
      </main>
    );
  return (
    <main class="speaker">
      <header class="speaker-head">
        <h1>
          {now.number} / {now.total} {now.title}
        </h1>
        <Watch />
      </header>
      <section class="speaker-now" aria-label="On the screen">
        <h2>{now.blank ? "The screen is blank" : "On the screen"}</h2>
        <SlidePicture hash={now.now} title="The present slide" />
      </section>
      <section class="speaker-next" aria-label="Next">
        <h2>{now.next ? "Next" : "This is the end"}</h2>
        {now.next && <SlidePicture hash={now.next} title="What comes next" />}
      </section>
      <section class="speaker-notes" aria-label="Notes">
        <h2>Notes</h2>
        <p class="speaker-text">{now.notes || "This slide has no notes."}</p>
      </section>
      <footer class="actions">
        <Button icon="back" onClick={() => send.current("back")}>
          Back
        </Button>
        <Button icon="forward" kind="primary" onClick={() => send.current("next")}>
          Next
        </Button>
        <Button icon="blank" pressed={now.blank} onClick={() => send.current("blank")}>
          Blank
        </Button>
      </footer>
    </main>
  );
}
