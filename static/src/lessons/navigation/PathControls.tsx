import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { Choice } from "../../ui/Choice";
import { written } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { PlayButton } from "../common/PlayButton";
import { useInSight, useSeen, useSteps } from "../common/useSteps";
import { RobotRadius } from "./Layers";
import { groundCosts, method, type Plan, pathGoal, pathStart, plan, planned, progress } from "./state";
import "./navigation.css";

const METHODS = [
  { value: "dijkstra", label: "Dijkstra" },
  { value: "a_star", label: "A*" },
];
const MS = 40;
const PART = 0.02;

/** The same search by both algorithms. */
function bothSearches(): { readonly wave: Plan; readonly directed: Plan } {
  const other = planned(groundCosts.value, pathStart.value, pathGoal.value, method.value !== "a_star");
  return method.value === "a_star" ? { wave: other, directed: plan.value } : { wave: plan.value, directed: other };
}

/** The controls of the search for a path, and what both algorithms need for it. */
export function PathControls() {
  const root = useRef<HTMLDivElement>(null);
  const playing = useSignal(false);
  useSteps(
    playing,
    useSeen(root),
    () => MS,
    () => {
      progress.value = Math.min(1, progress.peek() + PART);
      if (progress.peek() >= 1) playing.value = false;
    },
  );
  const { wave, directed } = useInSight(root, bothSearches);
  const count = (cells: number): string => cells.toLocaleString("en");
  return (
    <div class="path-controls stack-narrow" ref={root}>
      <div class="figure-controls no-print">
        <Choice
          label="Search"
          options={METHODS}
          value={method.value}
          sentence="Dijkstra expands cells by their cost to come, A* by that and an estimate of the cost to go."
          onChange={(value) => {
            method.value = value === "a_star" ? "a_star" : "dijkstra";
          }}
        />
        <PlayButton
          playing={playing}
          play="Search"
          isPrimary
          onPress={() => {
            if (!playing.peek() && progress.peek() >= 1) progress.value = 0;
          }}
        />
        <Slider
          label="Progress"
          sentence="How much of the search is shown; the path appears at its end."
          value={Math.round(100 * progress.value)}
          initial={100}
          low={0}
          high={100}
          step={1}
          unit="%"
          onInput={(value) => {
            playing.value = false;
            progress.value = value / 100;
          }}
        />
        <RobotRadius sentence="Radius of the robot: cells nearer than this to an obstacle are blocked." />
      </div>
      <div class="table-room">
        <table class="plain-table">
          <thead>
            <tr>
              <th scope="col">search</th>
              <th scope="col">cells expanded</th>
              <th scope="col">path</th>
            </tr>
          </thead>
          <tbody>
            {[
              { name: "Dijkstra", found: wave },
              { name: "A*", found: directed },
            ].map(({ name, found }) => (
              <tr key={name}>
                <th scope="row">{name}</th>
                <td>{count(found.order.length)}</td>
                <td>{found.path ? `${written(found.length, 1)} m` : "none"}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </div>
  );
}
