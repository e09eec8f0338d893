import { Matching } from "../../lessons/matching/Matching";
import { Sketch } from "../../lessons/matching/Sketch";
import { REALIZATIONS } from "./realizations";
import { Section, type SectionHead } from "./Section";

export function MatchingSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Matching />}
      sources={[
        ["besl-mckay", ""],
        ["censi", ""],
        ["olson", ""],
        ["hess", "for the bounds from coarser rasters"],
        ["ransac", ""],
      ]}
      after={
        <>
          <p>
            The <b class="noun-beam">colour</b> under the scans is the score of every position at the present heading:
            the nearer the end points lie to those of the other scan, the higher. The segments join each point to the
            nearest one. <b>Point to point</b> makes the segments short; <b>point to line</b> makes only their part
            across the wall short, and so lets a scan slide along a wall. Both need a start in the{" "}
            <b class="noun-miss">blue</b> part of the second picture. The <b>correlative</b> method tries every pose of
            its window and needs no good start within it, but its answer is as coarse as its steps.
          </p>
          <p>
            In the corridor the motion along the walls is not determined: any pose there fits. In the symmetric room two
            poses fit equally, and no score can tell them apart. A moved table shifts the pose a little; leaving out the
            worst tenth of the pairs, as here, limits this. A robot therefore uses the odometry as well.
          </p>
          <h3>The methods</h3>
          <ul class="realizations">
            {REALIZATIONS.map(({ name, sketch, sentence }) => (
              <li key={name}>
                <Sketch name={sketch} />
                <p>
                  <b>{name}.</b> {sentence}
                </p>
              </li>
            ))}
          </ul>
          <p>
            Dark is what is known, <b class="noun-robot">green</b> what is matched to it, computed from scans of the
            room above.
          </p>
        </>
      }
    >
      <p>
        To correct a pose, the scan is laid over another scan or over the map. Drag the <b class="noun-robot">scan</b>{" "}
        over the other one until it snaps; the outer handle turns it. The figure shows the first factor alone, with one
        scan as the map.
      </p>
    </Section>
  );
}
