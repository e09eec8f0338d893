import { Rays } from "../../../lessons/rays/Rays";
import { Worked } from "../../../lessons/rays/Worked";
import { Section, type SectionHead } from "../Section";

export function RaysSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Rays />}
      sources={["bresenham", "amanatides-woo"]}
      after={
        <>
          <h3>An example with all its numbers</h3>
          <p>
            The line from cell (0, 0) to cell (4, 3). The error starts at 0. Each step to the right adds 2dy; when the
            error is at least dx, the line also goes one cell up, and 2dx is subtracted. All numbers are integers; ∇ in
            the figure is the same number minus dx.
          </p>
          <Worked />
          <p>Every cell but the last is free; the last one is occupied.</p>
          <h3>All eight octants</h3>
          <p>
            As usually printed, the algorithm works in one octant: right and up, not steeper than 45°. Drag the{" "}
            <b class="noun-beam">end of the beam</b> around the <b class="noun-robot">sensor</b>. Two fixes make it work
            in all: <b>fix 1</b> steps with the signs of the differences, <b>fix 2</b> swaps the axes of a steep line.
            Switch one off: outside its octants the line ends in a wrong cell.
          </p>
          <p>
            Bresenham’s line leaves out cells that the beam only cuts at a corner. <b>Exact traversal</b> visits every
            cell that the beam crosses.
          </p>
        </>
      }
    >
      <p>
        A reading gives evidence for the cells <em>along its beam</em>. Bresenham’s algorithm finds them with integer
        additions only. The line covers <i>a</i> cells along its longer axis and <i>b</i> along the other. Each step
        goes one cell along the longer axis, and an error ∇, initially 2<i>b</i> − <i>a</i>, compares the true line with
        the middle between the two next cells: if ∇ is negative, the next step is <b class="noun-miss">straight</b>,
        otherwise <b class="noun-hit">diagonal</b>.
      </p>
    </Section>
  );
}
