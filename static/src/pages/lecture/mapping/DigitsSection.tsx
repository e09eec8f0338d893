import { signal } from "@preact/signals";
import { Prediction } from "../../../lessons/common/Prediction";
import { Digits } from "../../../lessons/digits/Digits";
import { type Readings, run, saturatedAt } from "../../../lessons/digits/model";
import { DragNumber } from "../../../ui/DragNumber";
import { written } from "../../../ui/numbers";
import { Section, type SectionHead, SectionLink } from "../Section";

const readings = signal<Readings>({ hits: 60, misses: 60, pHit: 0.9, pMiss: 0.1 });

/** The hits of the question. */
const WEAKER: Readings = { hits: 60, misses: 60, pHit: 0.75, pMiss: 0.25 };

/** The power of ten of q¹⁰⁰⁰. */
const POWER = (q: number): string => written(1000 * Math.log10(q), 0);

export function DigitsSection(head: SectionHead) {
  const { hits, misses, pHit } = readings.value;
  return (
    <Section
      {...head}
      figure={<Digits readings={readings} />}
      predict={
        <Prediction
          text="Each hit alone gives p = 0.75. After how many hits is p, computed in 32 bits, exactly 1?"
          axis={{ low: 0, high: 60, unit: "hits" }}
          step={1}
          because="Each hit multiplies the odds by 3. After 16 of them 1 − p is less than 2⁻²⁵, and p is rounded to 1."
          reveal={() => {
            readings.value = WEAKER;
            return saturatedAt(run(WEAKER), "p") ?? WEAKER.hits;
          }}
        />
      }
      sources={[
        ["probabilistic-robotics", "chapter 4"],
        ["ieee754", "binary32"],
      ]}
      after={
        <>
          <p>
            A product of probabilities fails too: a thousand factors of {(1 - pHit).toFixed(2)} make 10
            <sup>{POWER(1 - pHit)}</sup>, less than the smallest positive 32-bit number, 1.4 · 10⁻⁴⁵, and{" "}
            <b>underflow</b> to 0. Their logarithms add up to {written(1000 * Math.log(1 - pHit), 0)}.
          </p>
          <p>
            With ℓ clamped (<SectionLink to="forgetting" />) none of the three fails. Log-odds remain <b>cheaper</b> and{" "}
            <b>more exact</b>: one addition in place of two products, a sum and a division.
          </p>
        </>
      }
    >
      <p>
        Probability, odds and log-odds describe the same belief. Why store the logarithm? A wall is seen in many scans,
        so <i>p</i> comes close to 1, and just below 1, 32-bit numbers are 2<sup>−24</sup> apart.
      </p>
      <p>
        In the figure a cell is hit{" "}
        <DragNumber
          label="hits"
          sentence="Number of consecutive readings that are hits."
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
        then the wall is removed and{" "}
        <DragNumber
          label="misses"
          sentence="Number of misses after the hits."
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
        pass through the cell. A single hit gives{" "}
        <DragNumber
          label="probability that one hit gives"
          sentence="Probability of occupied after a single hit; a single miss gives one minus this."
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
        a single miss <i>p</i> = {(1 - pHit).toFixed(2)}. Everything is computed in 32 bits: Bayes’ rule for{" "}
        <b class="noun-beam">
          <i>p</i>
        </b>
        , a product of <b>odds</b>, and a sum of <b class="noun-robot">ℓ</b>.
      </p>
    </Section>
  );
}
