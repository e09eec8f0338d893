import { Rays } from "../../lessons/rays/Rays";
import { Worked } from "../../lessons/rays/Worked";
import { Section, type SectionHead } from "./Section";

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
            error is at least dx, the line also goes one cell up, and 2dx is subtracted. All numbers are integers. ∇ in
            the figure is the same number minus dx, so that it is compared with 0.
          </p>
          <Worked />
          <p>Every cell of the line but the last is free; the last one, with the end point, is occupied.</p>
          <h3>All eight octants</h3>
          <p>
            Drag the <b class="noun-beam">end of the beam</b> all the way around the <b class="noun-robot">sensor</b>.
            In the form that is usually printed, the algorithm works in one octant only: right and up, not steeper than
            45°. Bresenham also began with this octant and then gave the other seven their own moves. Two fixes have the
            same effect: <b>fix 1</b> steps with the signs of the differences, <b>fix 2</b> swaps the axes of a steep
            line. Switch one off and drag again: outside its octants the line ends in a wrong cell.
          </p>
          <p>
            Bresenham’s line steps from cell centre to cell centre and leaves out cells that the beam only cuts at a
            corner. <b>Exact traversal</b> visits every cell that the beam crosses, from border to border. The mapper
            offers both; Bresenham’s line is the default.
          </p>
        </>
      }
    >
      <p>
        A reading gives evidence for the cells <em>along its beam</em>. Which cells are these? Walking along the beam in
        steps of one resolution is simple, but slow, and misses cells or visits them twice. Bresenham’s algorithm finds
        them with integer additions only. Its line covers <i>a</i> cells along its longer axis and <i>b</i> along the
        other. Each step goes one cell along the longer axis, and an error term ∇, initially 2<i>b</i> − <i>a</i>,
        compares the height of the true line with the middle between the two next cells: if ∇ is negative, the next step
        is <b class="noun-miss">straight</b>, otherwise it is <b class="noun-hit">diagonal</b>.
      </p>
    </Section>
  );
}
