/** Formulas that stand in the text of a section. */

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
