import { Variables } from "../../../ui/text/Variables";
import "./speaker.css";
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { letterOf } from "../../../tools/classroom/histogram";
import { Button } from "../../../ui/Button";
import { SlidePicture } from "./deck/SlidePicture";
import { listenToKeys } from "./keys";
import type { Poll, PollAct } from "./poll";
import { followSlides, type Remote, type SpeakerState } from "./sync";

const two = (value: number): string => String(value).padStart(2, "0");

/** The time of day, and the time since the window was opened or the clock was reset, with the plan. */
function Watch({ plan }: { readonly plan: SpeakerState["plan"] }) {
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
        since the start
        {plan && (
          <span class="speaker-plan">
            {" "}
            · this slide until <span class="number">{plan.until}</span> of <span class="number">{plan.total}</span> min
          </span>
        )}{" "}
        · it is{" "}
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

const LABELS = {
  ask: "Ask the class",
  stop: "Close voting",
  reopen: "Open voting again",
  reveal: "Show the result",
} as const;

/** The question with the right answer and the counts. They are shown only here, not on the screen of the class. */
function PollPanel({ poll, act }: { readonly poll: Poll; readonly act: (act: PollAct) => void }) {
  const most = Math.max(1, ...poll.options.map(({ count }) => count ?? 0));
  return (
    <section class="speaker-poll" aria-label="Question">
      <h2>Question</h2>
      <p class="speaker-question">
        <Variables text={poll.text} />
      </p>
      <p role="status">{poll.status}</p>
      <ol>
        {poll.options.map(({ text, count, isRight }, i) => (
          <li key={text} class={isRight ? "is-right" : ""}>
            <b>{letterOf(i)}</b>
            <span>
              {text}
              {isRight && <em> ✓ right</em>}
            </span>
            {count !== null && (
              <>
                <b class="number">{count}</b>
                <i style={`width: ${(100 * count) / most}%`} aria-hidden="true" />
              </>
            )}
          </li>
        ))}
      </ol>
      {poll.acts.length > 0 && (
        <div class="actions">
          {poll.acts.map((name, i) => (
            <Button key={name} {...(i === 0 ? { kind: "primary" } : {})} onClick={() => act(name)}>
              {LABELS[name]}
            </Button>
          ))}
        </div>
      )}
    </section>
  );
}

/** The speaker's window: the present slide, the next step, and the notes. It controls the slides. */
export function SpeakerView({ channel }: { readonly channel: string }) {
  const state = useSignal<SpeakerState | null>(null);
  const send = useRef<Remote | null>(null);
  useEffect(() => {
    document.title = "Speaker · Gridbloom";
    send.current = followSlides(channel, (next) => {
      state.value = next;
    });
    return listenToKeys(
      window,
      (act) => act !== "exit" && send.current?.act(act),
      () => true,
    );
  }, [channel, state]);
  const now = state.value;
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
        <Watch plan={now.plan} />
      </header>
      <section class="speaker-now" aria-label="On the screen">
        <h2>{now.blank ? "The screen is blank" : "On the screen"}</h2>
        <SlidePicture hash={now.now} title="The present slide" />
      </section>
      <section class="speaker-next" aria-label="Next">
        <h2>{now.next ? "Next" : "This is the end"}</h2>
        {now.next && <SlidePicture hash={now.next} title="What comes next" />}
      </section>
      <div class="speaker-side">
        <section class="speaker-notes" aria-label="Notes">
          <h2>Notes</h2>
          <p class="speaker-text">{now.notes || "This slide has no notes."}</p>
        </section>
        {now.poll && <PollPanel poll={now.poll} act={(name) => send.current?.poll(name)} />}
      </div>
      <footer class="actions">
        <Button icon="back" onClick={() => send.current?.act("back")}>
          Back
        </Button>
        <Button icon="forward" kind="primary" onClick={() => send.current?.act("next")}>
          Next
        </Button>
        <Button icon="blank" pressed={now.blank} onClick={() => send.current?.act("blank")}>
          Blank
        </Button>
      </footer>
    </main>
  );
}
