import { Endpoint } from "../../../lessons/endpoint/Endpoint";
import { OnStage, Section, type SectionHead } from "../Section";

export function EndpointSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <OnStage scene="endpoint" label="From a reading to the cell of its end point">
          <Endpoint />
        </OnStage>
      }
      sources={["laser-scan", "occupancy-grid"]}
      after={
        <p>
          Always round down: <code>floor</code>. Converting to an integer is wrong below zero: −0.3 becomes 0, not −1,
          and two columns become one. <span class="no-print">Move the origin to the right of the end point.</span>
        </p>
      }
    >
      <p>
        A scan holds only distances. The angle of beam <i>k</i> in the sensor’s frame is{" "}
        <b class="noun-beam">
          <i>α</i>
        </b>{" "}
        = angle_min + <i>k</i> · angle_increment. With the pose{" "}
        <b class="noun-robot">
          <i>x</i>, <i>y</i>, <i>θ</i>
        </b>{" "}
        of the sensor, the beam that measured{" "}
        <b class="noun-beam">
          <i>z</i>
        </b>{" "}
        ended at
      </p>
      <math display="block" class="lesson-formula">
        <mrow>
          <mo>(</mo>
          <mi class="noun-robot">x</mi>
          <mo>+</mo>
          <mi class="noun-beam">z</mi>
          <mi>cos</mi>
          <mo>(</mo>
          <mi class="noun-robot">θ</mi>
          <mo>+</mo>
          <mi class="noun-beam">α</mi>
          <mo>)</mo>
          <mo>,</mo>
          <mspace width="0.4em" />
          <mi class="noun-robot">y</mi>
          <mo>+</mo>
          <mi class="noun-beam">z</mi>
          <mi>sin</mi>
          <mo>(</mo>
          <mi class="noun-robot">θ</mi>
          <mo>+</mo>
          <mi class="noun-beam">α</mi>
          <mo>)</mo>
          <mo>)</mo>
        </mrow>
      </math>
      <p>
        The grid has an <b>origin</b>, the world position of its lower left corner, and a <b>resolution</b>, the side of
        a cell. Column and row are the distances from the origin, counted in cells and rounded down.{" "}
        <span class="no-print">
          Drag the <b class="noun-robot">robot</b>, the origin (the two arrows), and the resolution.
        </span>
      </p>
    </Section>
  );
}
