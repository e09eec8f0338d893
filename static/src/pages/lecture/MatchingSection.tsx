import { Matching } from "../../lessons/matching/Matching";
import { REALIZATIONS } from "./realizations";
import { Section } from "./Section";

export function MatchingSection({ id, number, title }: { id: string; number: number; title: string }) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Matching />}
      sources={[
        ["probabilistic-robotics", "sections 6.4 and 6.5, for the likelihood of a scan in a map"],
        ["besl-mckay", ""],
        ["censi", ""],
        ["olson", ""],
        ["hess", ""],
      ]}
      after={
        <>
          <p>
            The <b class="noun-beam">colour</b> beneath the scans is the score of every position at the present heading:
            the nearer the end points lie to those of the other scan, the higher. The segments join each point to the
            nearest one. <b>Point to point</b> makes the segments short; <b>point to line</b> makes only their part
            across the wall short, and so lets a scan slide along a wall. Both need a start in the{" "}
            <b class="noun-miss">blue</b> part of the second picture. The <b>correlative</b> method tries every pose of
            its window and needs no good start within it, but its answer is as coarse as its steps.
          </p>
          <p>
            In the corridor the motion along the walls is not determined: any pose there fits. In the symmetric room two
            poses fit equally, and no score can tell them apart. A moved table pulls the pose a little; leaving out the
            worst tenth of the pairs, as here, limits this. A robot therefore uses the odometry as well.
          </p>
          <h3>The methods</h3>
          <table class="realizations">
            <thead>
              <tr>
                <th scope="col">Method</th>
                <th scope="col">What it does</th>
              </tr>
            </thead>
            <tbody>
              {REALIZATIONS.map(({ name, sentence }) => (
                <tr key={name}>
                  <th scope="row">{name}</th>
                  <td>{sentence}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </>
      }
    >
      <p>
        So far every pose was given. Wheels slip, and the errors of raw odometry add up: after a few turns the same wall
        is drawn in several places. A lidar is often more accurate than the odometry between two scans. So the pose is
        corrected before the scan is added to the map: the most probable pose, given the new scan and the odometry,
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
        The <b class="noun-beam">first factor</b> says how well the scan z fits the map m so far, the{" "}
        <b class="noun-robot">second</b> how well the pose fits the odometry u. Earlier poses are not changed. The
        figure shows the first factor alone, with one scan as the map. Drag the <b class="noun-robot">scan</b> over the
        other one until it snaps; the outer handle turns it.
      </p>
    </Section>
  );
}
