import type { SonarSettings } from "../../../lessons/sonar/model";
import { Sonar } from "../../../lessons/sonar/Sonar";
import { sonarMethod, sonarSettings } from "../../../lessons/stage/controls";
import { Choice } from "../../../ui/Choice";
import { DragNumber } from "../../../ui/DragNumber";
import { Section, type SectionHead, SectionLink } from "../Section";

const DEGREE = Math.PI / 180;
const METHODS = [
  { value: "sonar_cone", label: "Bayes filter" },
  { value: "moravec_elfes", label: "Moravec and Elfes" },
];

export function SonarSection(head: SectionHead) {
  const { opening, window: w } = sonarSettings.value;
  const set = (change: Partial<SonarSettings>): void => {
    sonarSettings.value = { ...sonarSettings.peek(), ...change };
  };
  return (
    <Section
      {...head}
      figure={
        <>
          <Sonar settings={sonarSettings} />
          <div class="for-stage no-print">
            <Choice
              label="On the stage: echoes are combined by"
              options={METHODS}
              value={sonarMethod.value}
              onChange={(value) => {
                sonarMethod.value = value === "moravec_elfes" ? value : "sonar_cone";
              }}
            />
          </div>
        </>
      }
      sources={["moravec-elfes", "elfes", ["probabilistic-robotics", "chapter 9"]]}
      after={
        <>
          <p>
            The <b>Bayes filter</b>, cell by cell, adds the evidence of one echo to every cell of the arc. Other cones
            pass most of these cells and correct them; where arcs from both jambs cross the open door, the map shows a
            wall.
          </p>
          <p>
            <b>Moravec and Elfes</b> stored two numbers per cell, how certainly it is <b class="noun-hit">occupied</b>{" "}
            (Occ) and <b class="noun-miss">empty</b> (Emp). One echo makes each cell of the arc occupied with the
            certainty O, which is reduced where the cell is known to be empty, scaled so that the whole arc holds one
            obstacle, and only then added:
          </p>
          <math display="block" class="lesson-formula">
            <mrow>
              <mi>O</mi>
              <mo>←</mo>
              <mfrac>
                <mrow>
                  <mi>O</mi>
                  <mo>(</mo>
                  <mn>1</mn>
                  <mo>−</mo>
                  <mi class="noun-miss">Emp</mi>
                  <mo>)</mo>
                </mrow>
                <mrow>
                  <mo>∑</mo>
                  <mi>O</mi>
                  <mo>(</mo>
                  <mn>1</mn>
                  <mo>−</mo>
                  <mi class="noun-miss">Emp</mi>
                  <mo>)</mo>
                </mrow>
              </mfrac>
            </mrow>
          </math>
          <math display="block" class="lesson-formula">
            <mrow>
              <mi class="noun-hit">Occ</mi>
              <mo>←</mo>
              <mi class="noun-hit">Occ</mi>
              <mo>+</mo>
              <mi>O</mi>
              <mo>−</mo>
              <mi class="noun-hit">Occ</mi>
              <mo>⋅</mo>
              <mi>O</mi>
            </mrow>
          </math>
          <p>
            This is a heuristic: both numbers can only grow, and the order of the readings matters. By 1989 Elfes had
            based the grid on Bayes’ rule, with independent cells (<SectionLink to="grid" />
            ): an echo counts for its whole arc again.
          </p>
        </>
      }
    >
      <p>
        A laser beam is thin; the beam of a sonar is a cone, here{" "}
        <DragNumber
          label="opening of the cone"
          sentence="The angle, from edge to edge, in which a sonar receives echoes."
          value={Math.round(opening / DEGREE)}
          text={`${Math.round(opening / DEGREE)}° wide`}
          tone="beam"
          low={6}
          high={60}
          step={1}
          after="."
          onInput={(value) => set({ opening: value * DEGREE })}
        />{" "}
        An echo from distance{" "}
        <b class="noun-beam">
          <i>z</i>
        </b>{" "}
        means two things: the cone is probably <b class="noun-miss">free</b> up to <i>z</i>, and somewhere on the arc at{" "}
        <i>z</i>, in a window of{" "}
        <DragNumber
          label="hit window of the cone"
          sentence="Thickness of the arc that counts as hit."
          value={w}
          unit="m"
          tone="hit"
          low={0.1}
          high={0.6}
          step={0.05}
          after=","
          onInput={(value) => set({ window: value })}
        />{" "}
        there is an <b class="noun-hit">obstacle</b>. It does not say where on the arc. The figure shows two maps from
        the same readings of a robot with 16 sonars.
      </p>
    </Section>
  );
}
