import { signal } from "@preact/signals";
import { Digits } from "../../lessons/digits/Digits";
import type { Readings } from "../../lessons/digits/model";
import { Scrub } from "../../ui/Scrub";
import { Section } from "./Section";

const readings = signal<Readings>({ hits: 60, misses: 60, pHit: 0.9, pMiss: 0.1 });

export function DigitsSection({ id, number, title }: { id: string; number: number; title: string }) {
  const { hits, misses, pHit } = readings.value;
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Digits readings={readings} />}
      sources={[
        ["probabilistic-robotics", "section 4.2"],
        ["ieee754", "binary32"],
      ]}
      after={
        <p>
          The mapper keeps ℓ in 32 bits for another reason too: an addition is cheaper than the products and the
          division that normalises them, and a map is millions of these. With the clamp of section 2 none of the three
          would ever get this far: at +3.5 even <i>p</i> has digits to spare. Without it <i>p</i> gives up first, the
          odds next, and the sum goes on.
        </p>
      }
    >
      <p>
        Odds and log-odds hold the same belief, and so does <i>p</i> itself. Why prefer the logarithm? Because a robot
        looks at a wall for a long time, and a machine’s number has few digits: 24 bits of them in the 32 that a cell
        gets.
      </p>
      <p>
        Here a cell is hit{" "}
        <Scrub
          label="hits"
          sentence="How many readings in a row say that the cell is occupied."
          value={hits}
          tone="hit"
          low={0}
          high={150}
          step={1}
          text={`${hits} times`}
          onInput={(value) => {
            readings.value = { ...readings.peek(), hits: value };
          }}
          after=","
        />{" "}
        then the wall is torn down and{" "}
        <Scrub
          label="misses"
          sentence="How many readings after them say that it is free."
          value={misses}
          tone="miss"
          low={0}
          high={150}
          step={1}
          text={`${misses} beams`}
          onInput={(value) => {
            readings.value = { ...readings.peek(), misses: value };
          }}
        />{" "}
        pass. One reading alone says{" "}
        <Scrub
          label="probability that one hit gives"
          sentence="How sure one reading alone is; a miss is as sure of the opposite."
          value={pHit}
          tone="hit"
          low={0.55}
          high={0.95}
          step={0.05}
          text={`p = ${pHit.toFixed(2)}`}
          onInput={(value) => {
            readings.value = { ...readings.peek(), pHit: value, pMiss: 1 - value };
          }}
          after=","
        />{" "}
        and as much against. Every step is computed in 32 bits, three ways: Bayes’ rule on <b class="noun-beam">p</b>, a
        product of <b>odds</b>, a sum of <b class="noun-robot">ℓ</b>. The mapper does the third; the other two are here
        to show why.
      </p>
    </Section>
  );
}
