import { computed, signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { probability } from "../../../grid/cellValues";
import { type CellEvent, logOddsHistory } from "../../../grid/sensorModel";
import { Cell } from "../../../lessons/cell/Cell";
import { cellParameters, numbersOf, setParameter } from "../../../lessons/common/parameters";
import { DragNumber } from "../../../ui/DragNumber";
import { signed, written } from "../../../ui/numbers";
import { Sub } from "../formulas";
import { Section, type SectionHead, SectionLink } from "../Section";

/** The cell has no reading at first: text and slide ask about four hits. */
const events = signal<readonly CellEvent[]>([]);
const path = computed(() => logOddsHistory(events.value, cellParameters.value));

/** z with its index: all readings up to t (1:t), or reading t alone. */
const Readings = ({ z }: { z: string }) => (
  <msub>
    <mi>z</mi>
    <mtext>{z}</mtext>
  </msub>
);

/** The poses of the sensor, with the same index. */
const Poses = ({ x }: { x: string }) => (
  <msub>
    <mi>x</mi>
    <mtext>{x}</mtext>
  </msub>
);

/** The cell, occupied. */
const CELL = <Sub of="m" at="i" />;

/** p(m_i | z₁…z_t, x₁…x_t), the belief; the cell may be free instead. */
function Given({ what, z, free = false }: { what: "belief" | "one" | "prior"; z?: string; free?: boolean }) {
  const tone = what === "belief" ? "noun-robot" : what === "one" ? "noun-beam" : "noun-prior";
  return (
    <mrow class={tone}>
      <mi>p</mi>
      <mo>(</mo>
      {free && <mo>¬</mo>}
      {CELL}
      {z && (
        <>
          <mo>∣</mo>
          <Readings z={z} />
          <mo>,</mo>
          <Poses x={z} />
        </>
      )}
      <mo>)</mo>
    </mrow>
  );
}

function Line({ why, children }: { why: ComponentChildren; children: ComponentChildren }) {
  return (
    <div class="derivation-line">
      <math display="block">
        <mrow>{children}</mrow>
      </math>
      <p>{why}</p>
    </div>
  );
}

/** p(z_t | m_i, x_t). */
const Likelihood = () => (
  <mrow>
    <mi>p</mi>
    <mo>(</mo>
    <Readings z="t" />
    <mo>∣</mo>
    {CELL}
    <mo>,</mo>
    <Poses x="t" />
    <mo>)</mo>
  </mrow>
);

/** From Bayes' rule to a sum, one step per line. */
function Derivation() {
  return (
    <div class="derivation">
      <Line
        why={
          <>
            Bayes’ rule for the newest reading <i>z</i>
            <sub>
              <i>t</i>
            </sub>
            . Two <b>Markov assumptions</b>: given the cell, older readings do not help to predict the new one (strictly
            true only given the whole map); and the new pose alone says nothing about the cell.
          </>
        }
      >
        <Given what="belief" z="1:t" />
        <mo>=</mo>
        <mfrac>
          <mrow>
            <Likelihood />
            <Given what="belief" z="1:t−1" />
          </mrow>
          <mrow>
            <mi>p</mi>
            <mo>(</mo>
            <Readings z="t" />
            <mo>∣</mo>
            <Readings z="1:t−1" />
            <mo>,</mo>
            <Poses x="1:t" />
            <mo>)</mo>
          </mrow>
        </mfrac>
      </Line>
      <Line
        why={
          <>
            Bayes’ rule again, in the other direction. Now only the <b class="noun-beam">inverse model</b> is needed:
            the probability of the cell given one reading. The <b>independence of map and poses</b> is used here:{" "}
            <i>p</i>(<i>m</i>
            <sub>
              <i>i</i>
            </sub>{" "}
            ∣ <i>x</i>
            <sub>
              <i>t</i>
            </sub>
            ) = <i>p</i>(<i>m</i>
            <sub>
              <i>i</i>
            </sub>
            ), the <b class="noun-prior">prior</b>.
          </>
        }
      >
        <Likelihood />
        <mo>=</mo>
        <mfrac>
          <mrow>
            <Given what="one" z="t" />
            <mi>p</mi>
            <mo>(</mo>
            <Readings z="t" />
            <mo>∣</mo>
            <Poses x="t" />
            <mo>)</mo>
          </mrow>
          <Given what="prior" />
        </mfrac>
      </Line>
      <Line
        why={
          <>
            The same for the free cell ¬<i>m</i>
            <sub>
              <i>i</i>
            </sub>
            ; then divide. The factors that are hard to know cancel out. What remains: the odds from the new reading,
            times the odds before it, divided by the prior odds.
          </>
        }
      >
        <mfrac>
          <Given what="belief" z="1:t" />
          <Given what="belief" z="1:t" free />
        </mfrac>
        <mo>=</mo>
        <mfrac>
          <Given what="one" z="t" />
          <Given what="one" z="t" free />
        </mfrac>
        <mo>⋅</mo>
        <mfrac>
          <Given what="belief" z="1:t−1" />
          <Given what="belief" z="1:t−1" free />
        </mfrac>
        <mo>⋅</mo>
        <mfrac>
          <Given what="prior" free />
          <Given what="prior" />
        </mfrac>
      </Line>
      <Line
        why={
          <>
            The logarithm of these <b>odds</b> is ℓ, the <b>log-odds</b>: the product becomes a sum.
          </>
        }
      >
        <msub class="noun-robot">
          <mi>ℓ</mi>
          <mi>t</mi>
        </msub>
        <mo>=</mo>
        <msub class="noun-robot">
          <mi>ℓ</mi>
          <mrow>
            <mi>t</mi>
            <mo>−</mo>
            <mn>1</mn>
          </mrow>
        </msub>
        <mo>+</mo>
        <mrow class="noun-beam">
          <mi>log</mi>
          <mfrac>
            <mrow>
              <mi>p</mi>
              <mo>(</mo>
              {CELL}
              <mo>∣</mo>
              <Readings z="t" />
              <mo>,</mo>
              <Poses x="t" />
              <mo>)</mo>
            </mrow>
            <mrow>
              <mi>p</mi>
              <mo>(</mo>
              <mo>¬</mo>
              {CELL}
              <mo>∣</mo>
              <Readings z="t" />
              <mo>,</mo>
              <Poses x="t" />
              <mo>)</mo>
            </mrow>
          </mfrac>
        </mrow>
        <mo>−</mo>
        <msub class="noun-prior">
          <mi>ℓ</mi>
          <mn>0</mn>
        </msub>
      </Line>
      <Line why="The probability is computed from ℓ when needed.">
        <mi>p</mi>
        <mo>=</mo>
        <mn>1</mn>
        <mo>−</mo>
        <mfrac>
          <mn>1</mn>
          <mrow>
            <mn>1</mn>
            <mo>+</mo>
            <mi>exp</mi>
            <mspace width="0.2em" />
            <mi class="noun-robot">ℓ</mi>
          </mrow>
        </mfrac>
      </Line>
    </div>
  );
}

/** The last update of the figure's cell as numbers. */
function LastUpdate() {
  const last = events.value.at(-1);
  const [before, after] = path.value.slice(-2);
  if (!last || before === undefined || after === undefined) return <p>No reading yet: the cell has its prior value.</p>;
  const { hit, miss } = numbersOf(cellParameters.value);
  const evidence = last === "hit" ? hit : miss;
  const clamped = Math.abs(before + evidence - after) > 1e-9;
  return (
    <p>
      The last reading was a <b class={`noun-${last}`}>{last}</b>:{" "}
      <span class="number">
        {written(before, 2)} {evidence < 0 ? "−" : "+"} {written(Math.abs(evidence), 2)} ={" "}
        {written(before + evidence, 2)}
        {clamped && `, clamped to ${written(after, 2)}`}
      </span>
      , which is <i>p</i> = {written(probability(after), 2)}.
    </p>
  );
}

export function CellSection(head: SectionHead) {
  const { log_odds_hit, log_odds_miss } = cellParameters.value;
  return (
    <Section
      {...head}
      figure={
        <div class="narrow-figure">
          <Cell parameters={cellParameters} events={events} />
        </div>
      }
      sources={[
        ["probabilistic-robotics", "table 4.2"],
        ["octomap", "section 5.1 (increments and clamp)"],
      ]}
      after={
        <>
          <LastUpdate />
          <p>
            Why is adding enough? This is the <b>binary Bayes filter for a static state</b>: the cell does not change,
            so nothing has to be predicted between two readings. Each reading multiplies the odds by a factor, one of{" "}
            <i>p</i> = 0.7 by 7/3; the logarithm turns products into sums.
          </p>
          <Derivation />
          <p>
            A reading adds the <b class="noun-beam">middle term</b> minus <b class="noun-prior">ℓ₀</b>. The prior, 0 for{" "}
            <i>p</i> = 0.5, is subtracted because the inverse model contains it: otherwise every reading would count it
            again. The order of the readings does not matter, except at the dashed lines, where ℓ is <em>clamped</em> (
            <SectionLink to="forgetting" />
            ).
          </p>
        </>
      }
    >
      <p>
        The state of a cell is constant (assumption 2): either <i>m</i>
        <sub>
          <i>i</i>
        </sub>{" "}
        (occupied) or ¬<i>m</i>
        <sub>
          <i>i</i>
        </sub>{" "}
        (free). Its odds are <i>p</i>/(1 − <i>p</i>), occupied to free. The map stores their natural logarithm, the
        log-odds <b class="noun-robot">ℓ</b> = log(<i>p</i>/(1&nbsp;−&nbsp;<i>p</i>)): 0.85 for <i>p</i> = 0.7; above 0
        the cell is more likely occupied, below 0 more likely free; <i>p</i> = 1 is +∞, <i>p</i> = 0 is −∞. Before the
        first reading ℓ is <b class="noun-prior">ℓ₀</b>, the log-odds of the prior.
      </p>
      <p>
        A <b class="noun-hit">hit</b>, a beam that ended in the cell, adds{" "}
        <DragNumber
          label="evidence of a hit"
          sentence="By how much a hit raises the log-odds of the cell."
          value={log_odds_hit}
          text={signed(log_odds_hit)}
          tone="hit"
          low={0}
          high={3}
          step={0.05}
          onInput={(value) => setParameter("log_odds_hit", value)}
          after=","
        />{" "}
        a <b class="noun-miss">miss</b>, a beam that passed through it, adds{" "}
        <DragNumber
          label="evidence of a miss"
          sentence="By how much a miss lowers the log-odds of the cell."
          value={log_odds_miss}
          text={signed(log_odds_miss)}
          tone="miss"
          low={-3}
          high={0}
          step={0.05}
          onInput={(value) => setParameter("log_odds_miss", value)}
          after="."
        />{" "}
        <span class="no-print">
          Press a button; then the keys <kbd>H</kbd> and <kbd>M</kbd> work too.
        </span>{" "}
        A cell was hit four times. After how many misses is it more likely free than occupied?
      </p>
    </Section>
  );
}
