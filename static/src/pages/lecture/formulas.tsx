/** Formulas in the text of a section. */

import type { ComponentChildren } from "preact";

/** A letter with an index. */
export const Sub = ({ of, at, tone }: { of: string; at: string; tone?: string }) => (
  <msub {...(tone ? { class: tone } : {})}>
    <mi>{of}</mi>
    <mtext>{at}</mtext>
  </msub>
);

/** p( what | given ). */
export function P({ children, given }: { children: ComponentChildren; given?: ComponentChildren }) {
  return (
    <mrow>
      <mi>p</mi>
      <mo>(</mo>
      {children}
      {given && (
        <>
          <mo>∣</mo>
          {given}
        </>
      )}
      <mo>)</mo>
    </mrow>
  );
}

const READINGS = (
  <>
    <Sub of="z" at="1:t" tone="noun-beam" />
    <mo>,</mo>
    <Sub of="x" at="1:t" tone="noun-robot" />
  </>
);

/** p(m | z, x) as the product over the cells. */
export function MapProduct() {
  return (
    <math display="block" class="lesson-formula">
      <mrow>
        <P given={READINGS}>
          <mi>m</mi>
        </P>
        <mo>=</mo>
        <munder>
          <mo>∏</mo>
          <mi>i</mi>
        </munder>
        <P given={READINGS}>
          <Sub of="m" at="i" />
        </P>
      </mrow>
    </math>
  );
}

/** p(m | z) by Bayes' rule. */
export function BayesRule() {
  const z = <mi class="noun-beam">z</mi>;
  const m = <mi>m</mi>;
  return (
    <math display="block" class="lesson-formula">
      <mrow>
        <P given={z}>{m}</P>
        <mo>=</mo>
        <mfrac>
          <mrow>
            <P given={m}>{z}</P>
            <mspace width="0.2em" />
            <mrow class="noun-prior">
              <P>{m}</P>
            </mrow>
          </mrow>
          <P>{z}</P>
        </mfrac>
      </mrow>
    </math>
  );
}

/** 2 / (9 (B − 1)), a term of the number of particles. */
const KLD_PART = (
  <mfrac>
    <mn>2</mn>
    <mrow>
      <mn>9</mn>
      <mo>(</mo>
      <mi>B</mi>
      <mo>−</mo>
      <mn>1</mn>
      <mo>)</mo>
    </mrow>
  </mfrac>
);

/** The number of particles of KLD sampling: Probabilistic Robotics, table 8.4. */
export function KldNumber() {
  return (
    <math display="block" class="lesson-formula">
      <mrow>
        <mi>M</mi>
        <mo>=</mo>
        <mfrac>
          <mrow>
            <mi>B</mi>
            <mo>−</mo>
            <mn>1</mn>
          </mrow>
          <mrow>
            <mn>2</mn>
            <mi>ε</mi>
          </mrow>
        </mfrac>
        <msup>
          <mrow>
            <mo>(</mo>
            <mn>1</mn>
            <mo>−</mo>
            {KLD_PART}
            <mo>+</mo>
            <msqrt>{KLD_PART}</msqrt>
            <mi>q</mi>
            <mo>)</mo>
          </mrow>
          <mn>3</mn>
        </msup>
      </mrow>
    </math>
  );
}
