import { signal } from "@preact/signals";
import { INITIAL_CONFIG } from "../../../grid/occupancyGrid";
import { Forgetting } from "../../../lessons/forgetting/Forgetting";
import type { Clamp } from "../../../lessons/forgetting/model";
import { scansAfter } from "../../../lessons/stage/controls";
import { bound } from "../../../ui/bound";
import { DragNumber } from "../../../ui/DragNumber";
import { signed } from "../../../ui/numbers";
import { Slider } from "../../../ui/Slider";
import { Section, type SectionHead, SectionLink } from "../Section";

const seen = signal(40);
const clamp = signal<Clamp>({ on: true, low: INITIAL_CONFIG.log_odds_min, high: INITIAL_CONFIG.log_odds_max });

export function ForgettingSection(head: SectionHead) {
  const { low, high } = clamp.value;
  return (
    <Section
      {...head}
      figure={
        <>
          <Forgetting seen={seen} clamp={clamp} />
          <div class="for-stage no-print">
            <Slider
              label="On the stage: scans since the table was removed"
              sentence="How many scans the robot of the stage has taken since the table was removed."
              {...bound(scansAfter)}
              initial={4}
              low={0}
              high={15}
              step={1}
              unit="scans"
            />
          </div>
        </>
      }
      sources={[
        ["octomap", "section 5.1 (clamp)"],
        ["probabilistic-robotics", "section 4.2"],
      ]}
      after={
        <p>
          Without a clamp the misses must outweigh all hits: a table seen for one hour needs about two hours to
          disappear. The clamp limits the certainty of a cell, and with it the number of misses needed. The price: a
          correct cell changes as quickly as a wrong one. OctoMap also compresses by it: cells at the limit are equal,
          so eight of them become one (
          <SectionLink to="octree" />
          ).
        </p>
      }
    >
      <p>
        The second assumption fails in practice: things are moved. In the figure a table has been in view for{" "}
        <DragNumber
          label="scans with the table"
          sentence="Number of scans that saw the table before it is removed."
          {...bound(seen)}
          text={`${seen.value} scans`}
          tone="hit"
          low={2}
          high={80}
          step={1}
          after="."
        />{" "}
        A clamp keeps ℓ between{" "}
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
        The table counts as <b>forgotten</b> when nine in ten of its cells are free (<i>p</i> &lt; 0.25).{" "}
        <span class="no-print">Guess, then remove the table.</span>
      </p>
    </Section>
  );
}
