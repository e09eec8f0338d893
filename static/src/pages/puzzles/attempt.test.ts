import { expect, test } from "vitest";
import type { Attempt, OfferedPuzzle } from "../../wire/http";
import { leadsToCase, nextPuzzle, progressText, resultText } from "./attempt";

const attempt = (given: Partial<Attempt>): Attempt =>
  ({ answer: null, best: 0, enough: 0.9, is_named: false, wrong: [], hints: [], ...given }) as Attempt;

test("a check leads to the case with the answer, and where only the cause is missing", () => {
  const answer = {
    cause: "drift",
    label: "",
    explanation: "",
    lesson: "",
    section: "",
    repair: {},
    trajectory: null,
    faulty: {},
    faulty_trajectory: "odometry",
  };
  expect(leadsToCase(attempt({ answer, is_named: true, best: 0.95 }))).toBe(true);
  expect(leadsToCase(attempt({ best: 0.9 }))).toBe(true);
  expect(leadsToCase(attempt({ best: 0.5 }))).toBe(false);
  expect(leadsToCase(attempt({ is_named: true, best: 0.5 }))).toBe(false);
});

test("a check says how far the repair is, and what is missing most", () => {
  const measured = (agreement: number, sharpness: number, entropy: number) => ({ agreement, sharpness, entropy });
  const checked = (given: Partial<Attempt>) =>
    progressText(
      attempt({
        measures: ["agreement", "sharpness", "entropy"],
        first: measured(0.2, 0.4, 0.5),
        goal: measured(0.8, 0.6, 0.3),
        now: measured(0.5, 0.6, 0.48),
        repair: 0.43,
        best: 0.43,
        ...given,
      }),
    );
  expect(checked({})).toBe("Repaired 43 %; it is solved at 90 %. Farthest from its goal: entropy.");
  expect(checked({ best: 0.6, measures: ["agreement"] })).toBe(
    "Repaired 43 %; it is solved at 90 %. The best so far was 60 %.",
  );
  expect(checked({ repair: 0, best: 0 })).toContain("Repaired 0 %: no better than at first; it is solved at 90 %.");
  expect(checked({ repair: 0.95, best: 0.95 })).toBe("Repaired 95 %. What was the cause?");
  expect(checked({ repair: null, now: null })).toBe("Not checked yet.");
});

test("the next puzzle is the first unsolved one in turn, never the same", () => {
  const puzzles = ["a", "b", "c"].map((name): OfferedPuzzle => ({ name, level: 1, title: name, story: "" }));
  const next = (name: string, ...solved: string[]) =>
    nextPuzzle(puzzles, name, Object.fromEntries(solved.map((name) => [name, 100])))?.name;
  expect(next("a")).toBe("b");
  expect(next("a", "a", "b")).toBe("c");
  expect(next("c", "c")).toBe("a");
  expect(next("b", "a", "c")).toBeUndefined();
  expect(next("b", "a", "b", "c")).toBeUndefined();
});

test("the result is one line with the address", () => {
  const solved = attempt({ title: "Detours", points: 80, wrong: ["drift"], hints: ["Look.", "Play."] });
  expect(resultText(solved, "http://here/puzzles.html?puzzle=ghost")).toBe(
    "“Detours”: 80 of 100 points, 1 wrong answer, 2 hints. http://here/puzzles.html?puzzle=ghost",
  );
  expect(resultText(attempt({ title: "A", points: 100 }), "x")).toContain("no wrong answers, no hints");
});
