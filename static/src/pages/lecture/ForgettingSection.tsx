import { signal } from "@preact/signals";
import { INITIAL_CONFIG } from "../../grid/occupancyGrid";
import { Forgetting } from "../../lessons/forgetting/Forgetting";
import type { Clamp } from "../../lessons/forgetting/model";
import { scansAfter } from "../../lessons/stage/controls";
import { DragNumber } from "../../ui/DragNumber";
import { signed } from "../../ui/numbers";
import { Slider } from "../../ui/Slider";
import { Section, type SectionHead } from "./Section";

const seen = signal(40);
const clamp = signal<Clamp>({ on: true, low: INITIAL_CONFIG.log_odds_min, high: INITIAL_CONFIG.log_odds_max });

export function ForgettingSection({ id, number, title }: SectionHead) {
  const { low, high } = clamp.value;
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <>
          <Forgetting seen={seen} clamp={clamp} />
          <div class="for-stage no-print">
            <Slider
              label="On the stage: scans since the cupboard was removed"
              sentence="How many scans the robot of the stage has taken since the cupboard was removed."
              value={scansAfter.value}
              initial={4}
              low={0}
              high={15}
              step={1}
              unit="scans"
              onInput={(value) => {
                scansAfter.value = value;
              }}
            />
          </div>
        </>
      }
      sources={[
        ["octomap", "for the clamp, which keeps a map able to change"],
        ["probabilistic-robotics", "chapter 4: a state that never changes"],
      ]}
      after={
        <p>
          Without a clamp the misses must outweigh all hits: with these increments a table that was seen for one hour
          needs about two hours to disappear. The clamp limits the certainty of a cell and therefore the number of
          misses that are needed: from the upper limit down to the threshold it is always the same. The disadvantage is
          that evidence beyond the limit is lost, so a correct cell can be changed as quickly as a wrong one. This is
          the only purpose of the clamp: it has nothing to do with the precision of a number.
        </p>
      }
    >
      <p>
        The second assumption, that the world does not change, is wrong in practice. In the figure a table has been in
        view of the robot for{" "}
        <DragNumber
          label="scans with the table"
          sentence="Number of scans that saw the table before it is removed."
          value={seen.value}
          text={`${seen.value} scans`}
          tone="hit"
          low={2}
          high={80}
          step={1}
          onInput={(value) => {
            seen.value = value;
          }}
          after="."
        />{" "}
        The mapper’s clamp keeps ℓ between{" "}
        <DragNumber
          label="lower clamp"
          sentence="Lower limit of the log-odds of a cell."
          value={low}
          text={signed(low, 1)}
          tone="miss"
          low={-10}
          high={-0.2}
          step={0.1}
          onInput={(value) => {
            clamp.value = { ...clamp.peek(), low: value };
          }}
        />{" "}
        and{" "}
        <DragNumber
          label="upper clamp"
          sentence="Upper limit of the log-odds of a cell."
          value={high}
          text={signed(high, 1)}
          tone="hit"
          low={0.7}
          high={10}
          step={0.1}
          onInput={(value) => {
            clamp.value = { ...clamp.peek(), high: value };
          }}
          after="."
        />{" "}
        The table is <b>forgotten</b> when nine in ten of its cells are free (p &lt; 0.25), here and in the lab. The map
        is updated per scan (see the next section): each scan adds to a cell either a hit,{" "}
        {signed(INITIAL_CONFIG.log_odds_hit)}, or a miss, {signed(INITIAL_CONFIG.log_odds_miss)}. First guess the number
        of scans, then remove the table.
      </p>
    </Section>
  );
}
