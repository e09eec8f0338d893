import { Rays } from "../../../lessons/rays/Rays";
import { Worked } from "../../../lessons/rays/Worked";
import { Section, type SectionHead } from "../Section";

export function RaysSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={<Rays />}
      sources={["bresenham", "amanatides-woo"]}
      after={
        <>
          <h3>A worked example</h3>
          <p>
            Here the error begins at 0, and each step adds 2dy; from dx on the line also goes one cell up, and 2dx is
            subtracted. ∇ is the sum minus dx.
          </p>
          <Worked />
          <h3>All eight octants</h3>
          <p>
            As usually printed, the algorithm works in one octant: right and up, not steeper than 45°. Two fixes make it
            work in all: <b>fix 1</b> steps with the signs of the differences, <b>fix 2</b> swaps the axes of a steep
            line.{" "}
            <span class="no-print">
              Switch one off and drag the <b class="noun-beam">end of the beam</b> around the{" "}
              <b class="noun-robot">sensor</b>: in some octants the line ends in a wrong cell.
            </span>
          </p>
          <p>
            Bresenham’s line leaves out cells that the beam only cuts at a corner; <b>exact traversal</b> visits every
            cell it crosses.
          </p>
        </>
      }
    >
      <p>
        A reading gives evidence for the cells <em>along its beam</em>. Bresenham’s algorithm finds them with integer
        additions only. The line goes dx cells along its longer axis, one with each step, and dy along the other. An
        error ∇, initially 2dy − dx, tells whether the true line passes below or above the middle between the two
        candidates for the next cell: if ∇ is negative, the next step is <b class="noun-miss">straight</b> and adds 2dy
        to it, otherwise <b class="noun-hit">diagonal</b>, and adds 2dy − 2dx.
      </p>
    </Section>
  );
}
