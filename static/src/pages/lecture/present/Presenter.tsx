import { useSignal } from "@preact/signals";
import { useEffect, useLayoutEffect } from "preact/hooks";
import { followedCode, questionInHeading } from "../../../store/classroom";
import { ClassButton } from "../../../tools/classroom/ClassHost";
import { letterOf } from "../../../tools/classroom/histogram";
import { Button } from "../../../ui/Button";
import { toast } from "../../../ui/Toast";
import { Variables } from "../../../ui/text/Variables";
import { act, canAct } from "./acts";
import { DeckEditor } from "./deck/DeckEditor";
import { titleOf } from "./deck/deck";
import { arrowsGoTo, listenToKeys } from "./keys";
import { keepScale } from "./scale";
import { answerOf } from "./shownAnswers";
import { blank, count, isPreview, place, predicted, presenting, questionOf, slide, stage, stepsOf } from "./state";
import { openSpeaker } from "./sync";

/** Keys and sizes of the slides while this page is open. */
export function usePresentation(): void {
  useEffect(() => {
    const stops = [keepScale(), listenToKeys(window, act, canAct)];
    return () => {
      for (const stop of stops) stop();
    };
  }, []);
}

function fullScreen(): void {
  const change = document.fullscreenElement ? document.exitFullscreen() : document.documentElement.requestFullscreen();
  change.catch(() => toast("The browser does not allow the full screen here.", "error"));
}

/** The parts of the slide announced so far: its question, and after the last step the answer. */
function Heading() {
  const now = slide.value;
  const question = questionOf(now);
  const begun = question && (stage.value === "figure" || stage.value === "answer");
  const heading = begun ? question.question : null;
  useLayoutEffect(() => {
    questionInHeading.value = heading;
    return () => {
      questionInHeading.value = null;
    };
  }, [heading]);
  if (!now) return null;
  const chosen = now.kind === "section" ? predicted.value[now.section] : undefined;
  const answer = answerOf(now);
  const isRight = chosen !== undefined && chosen === answer?.right;
  return (
    <div class="presenter-heading">
      <h1>
        <Variables text={heading ?? titleOf(now)} />
      </h1>
      {question && (
        <p class="presenter-answer" role="status">
          {begun && stage.value === "answer" && (
            <>
              {chosen !== undefined && (
                <b class={isRight ? "is-right" : "is-wrong"}>
                  {isRight ? "✓" : "×"} {letterOf(chosen)} is {isRight ? "right" : "wrong"}
                  {!isRight && answer?.right !== undefined && `, ${letterOf(answer.right)} is right`}.{" "}
                </b>
              )}
              {answer && <Variables text={answer.answer} />}
            </>
          )}
        </p>
      )}
    </div>
  );
}

function Steps() {
  const now = slide.value;
  const steps = now ? stepsOf(now) : 1;
  if (steps < 2) return null;
  return (
    <span class="presenter-steps" role="img" aria-label={`Step ${place.value.step + 1} of ${steps}`}>
      {Array.from({ length: steps }, (_, i) => (
        <i key={i} class={i <= place.value.step ? "done" : ""} />
      ))}
    </span>
  );
}

/** The bar above a slide. */
export function Presenter() {
  const arranging = useSignal(false);
  if (isPreview || followedCode !== null)
    return (
      <header class="presenter">
        <Heading />
      </header>
    );
  const { number, total } = count.value;
  return (
    <header class="presenter">
      <Heading />
      <div class="presenter-tools no-print">
        <p class="presenter-number">
          {number} / {total}
          <Steps />
        </p>
        <div class="actions">
          <Button icon="back" label="Back (←)" onClick={() => act("back")} />
          <Button icon="forward" label="Next (→)" onClick={() => act("next")} />
          <Button icon="blank" label="Blank the screen (B)" onClick={() => act("blank")} />
          <ClassButton iconOnly />
          <Button icon="fit" label="Full screen" onClick={fullScreen} />
          <Button
            icon="notes"
            label="Speaker’s window: notes and the next slide"
            onClick={() => {
              if (!openSpeaker()) toast("The browser has blocked the speaker’s window.", "error");
            }}
          />
          <Button
            icon="slides"
            label="Arrange the slides"
            onClick={() => {
              arranging.value = true;
            }}
          />
          <Button icon="close" label="Exit (Esc)" onClick={() => act("exit")} />
        </div>
      </div>
      {arrowsGoTo.value !== null && (
        <p class="presenter-arrows no-print" role="status">
          The arrow keys move “{arrowsGoTo.value}”. Esc gives them back to the slides.
        </p>
      )}
      {arranging.value && (
        <DeckEditor
          onClose={() => {
            arranging.value = false;
          }}
        />
      )}
    </header>
  );
}

/** A black screen over the slides. */
export function Blank() {
  if (!blank.value || !presenting.value) return null;
  return (
    <button type="button" class="blank-screen" onClick={() => act("blank")}>
      <span class="visually-hidden">The screen is blank. Press B or click to show the slide again.</span>
    </button>
  );
}
