// @vitest-environment happy-dom
import { render } from "preact";
import { afterEach, expect, test } from "vitest";
import { questionOnPage } from "../../../store/classroom";
import { QUESTIONS } from "./questions";
import { SlideQuestion } from "./SlideQuestion";
import { deck, place, presenting, questionOf, stage } from "./state";

afterEach(() => render(null, document.body));

test("options of a slide are announced before they are painted, so that the class's line does not show them twice", () => {
  const section = Object.entries(QUESTIONS).find(([, question]) => question?.options)?.[0] ?? "";
  presenting.value = true;
  place.value = {
    index: deck.value.slides.findIndex((slide) => questionOf(slide) === QUESTIONS[section as "cell"]),
    step: 1,
  };
  expect(stage.value).toBe("predict");
  render(<SlideQuestion id={section} />, document.body); // not in act(): effects after the paint do not run
  expect(document.querySelectorAll(".slide-option").length).toBeGreaterThan(1);
  expect(questionOnPage.value).toBe(QUESTIONS[section as "cell"]?.question);
});
