import { Rays } from "../../lessons/rays/Rays";
import { Section } from "./Section";

export function RaysSection({ id, number, title }: { id: string; number: number; title: string }) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<Rays />}
      sources={["bresenham", "amanatides-woo"]}
      after={
        <>
          <p>
            Drag the <b class="noun-beam">beam’s end</b> all the way round the <b class="noun-robot">sensor</b>. As it
            is mostly printed, the line works in one octant only: right and up, not steeper than 45°. Bresenham began
            there too, and then gave the other seven moves of their own. Two fixes do the same: <b>fix 1</b> steps with
            the signs of the differences, <b>fix 2</b> swaps the axes of a steep line. Switch one off, and drag again:
            outside its octants the line ends where no beam ended.
          </p>
          <p>
            Bresenham’s line is thin. It steps from cell centre to cell centre, and cells that the beam only cuts at a
            corner are left out. <b>Exact traversal</b> visits every cell that the beam crosses, border by border. The
            mapper offers both; the thin line is the default.
          </p>
        </>
      }
    >
      <p>
        A reading speaks of the cells <em>along its beam</em>. Which are they? Bresenham’s answer needs only whole
        numbers and additions. The line runs over <i>a</i> cells along its longer axis and over <i>b</i> along the
        other. It takes one step along the longer axis for each cell, and a number ∇, 2<i>b</i> − <i>a</i> at first,
        keeps the score of how far the true line has climbed: while ∇ is negative the next step goes{" "}
        <b class="noun-miss">straight</b>, otherwise it is <b class="noun-hit">diagonal</b>.
      </p>
    </Section>
  );
}
