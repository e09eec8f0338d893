import { signal } from "@preact/signals";
import { MostProbable, UNCERTAINTY } from "../../../lessons/probable/MostProbable";
import { DragNumber } from "../../../ui/DragNumber";
import { Section, type SectionHead } from "../Section";

const uncertainty = signal(UNCERTAINTY);

export function ProbableSection(head: SectionHead) {
  const { odometry, reading } = uncertainty.value;
  return (
    <Section
      {...head}
      figure={<MostProbable uncertainty={uncertainty} />}
      sources={[["probabilistic-robotics", "chapters 5 and 6"]]}
      after={
        <p>
          <b>With cabinets</b> one position fits the scan, and the product has its maximum there. <b>With doors</b> at
          equal distances several fit, and the odometry decides: wrongly, if it is off by more than half that distance.
          In the <b>bare</b> corridor every position fits, and the product is the odometry alone.
        </p>
      }
    >
      <p>
        Scan and odometry are both evidence about the pose. Before a scan is added to the map, its pose is set to the
        most probable one given both (maximum a posteriori, MAP):
      </p>
      <math display="block" class="lesson-formula pose-formula">
        <mrow>
          <msub>
            <mover>
              <mi>x</mi>
              <mo>^</mo>
            </mover>
            <mi>t</mi>
          </msub>
          <mo>=</mo>
          <munder>
            <mi>argmax</mi>
            <msub>
              <mi>x</mi>
              <mi>t</mi>
            </msub>
          </munder>
          <mspace width="0.2em" />
          <mi class="noun-beam">p</mi>
          <mo>(</mo>
          <msub>
            <mi>z</mi>
            <mi>t</mi>
          </msub>
          <mo>|</mo>
          <msub>
            <mi>x</mi>
            <mi>t</mi>
          </msub>
          <mo>,</mo>
          <mi>m</mi>
          <mo>)</mo>
          <mo>⋅</mo>
          <mi class="noun-robot">p</mi>
          <mo>(</mo>
          <msub>
            <mi>x</mi>
            <mi>t</mi>
          </msub>
          <mo>|</mo>
          <msub>
            <mi>u</mi>
            <mi>t</mi>
          </msub>
          <mo>,</mo>
          <msub>
            <mover>
              <mi>x</mi>
              <mo>^</mo>
            </mover>
            <mrow>
              <mi>t</mi>
              <mo>−</mo>
              <mn>1</mn>
            </mrow>
          </msub>
          <mo>)</mo>
        </mrow>
      </math>
      <p>
        The <b class="noun-beam">first factor</b> says how well the scan fits the map so far; each reading is uncertain
        by{" "}
        <DragNumber
          label="Measurement uncertainty"
          sentence="Standard deviation of the distance from an end point to its wall."
          value={reading}
          unit="m"
          tone="beam"
          low={0.02}
          high={0.5}
          step={0.01}
          onInput={(value) => {
            uncertainty.value = { ...uncertainty.peek(), reading: value };
          }}
          after="."
        />{" "}
        The <b class="noun-robot">second</b> says how well the pose fits the odometry <i>u</i>, which is uncertain by{" "}
        <DragNumber
          label="Odometry uncertainty"
          sentence="Standard deviation of the position by odometry."
          value={odometry}
          unit="m"
          low={0.05}
          high={2}
          step={0.05}
          onInput={(value) => {
            uncertainty.value = { ...uncertainty.peek(), odometry: value };
          }}
          after="."
        />{" "}
        <span class="no-print">Drag the diamond, where the odometry says that the robot is.</span>
      </p>
    </Section>
  );
}
