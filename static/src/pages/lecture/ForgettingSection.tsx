import { signal } from "@preact/signals";
import { INITIAL_CONFIG } from "../../grid/occupancyGrid";
import { Forgetting } from "../../lessons/forgetting/Forgetting";
import type { Clamp } from "../../lessons/forgetting/model";
import { signed } from "../../ui/numbers";
import { Scrub } from "../../ui/Scrub";
import { Section } from "./Section";

const seen = signal(40);
const clamp = signal<Clamp>({ on: true, low: INITIAL_CONFIG.log_odds_min, high: INITIAL_CONFIG.log_odds_max });

export function ForgettingSection({ id, number, title }: { id: string; number: number; title: string }) {
  const { low, high } = clamp.value;
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Forgetting seen={seen} clamp={clamp} />}
      sources={[
        ["octomap", "where the clamp keeps a map able to change"],
        ["probabilistic-robotics", "section 4.2: a state that never changes"],
      ]}
      after={
        <p>
          Without a clamp the map holds every hit against every miss, and a table that stood for an hour needs two to
          go. The clamp limits how sure a cell can be, and so how long it may take to change its mind: from the upper
          limit the way down to the threshold is always the same length. The price: beyond the limit, more evidence
          counts for nothing, and a cell can be talked out of the truth as quickly as out of an error.
        </p>
      }
    >
      <p>
        The second assumption said that the world stands still. It does not. Here a table has stood before the robot for{" "}
        <Scrub
          label="scans with the table"
          sentence="For how many scans the table was seen before it goes."
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
        <Scrub
          label="lower clamp"
          sentence="The least log-odds that a cell can have."
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
        <Scrub
          label="upper clamp"
          sentence="The greatest log-odds that a cell can have."
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
        Forgotten means: none of the table’s cells counts as occupied any more, p ≤ 0.65. Updated per scan, as the next
        section has it, a cell is told one thing a scan: a hit, {signed(INITIAL_CONFIG.log_odds_hit)}, or a miss,{" "}
        {signed(INITIAL_CONFIG.log_odds_miss)}. Say a number first, then take the table away.
      </p>
    </Section>
  );
}
