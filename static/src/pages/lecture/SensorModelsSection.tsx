import { LaterFigure } from "./LaterFigure";
import { Section, type SectionHead } from "./Section";
import { SectionLink } from "./SectionLink";

export function SensorModelsSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<LaterFigure id="sensor-models" />}
      sources={[["probabilistic-robotics", "tables 6.1 and 6.3, section 9.3"], "amcl"]}
      after={
        <>
          <p>
            Why can’t we get the inverse model from p(z | m) alone? It is a distribution over <b>readings</b>, for one
            whole map. A cell needs a distribution over its two <b>states</b>: Bayes’ rule also takes a prior, and sums
            over all maps that agree with the reading. Cells before z are free <i>because</i> the beam passed them;
            cells behind it keep their prior <i>because</i> nothing was measured there. The dashed curve, log p(z |
            occupied at r) / p(z | not), is low in both places and cannot tell them apart.
          </p>
          <p>
            Combining several sources in a row, the correct step is this ratio, log p(y | c) / p(y | ¬c). Programs often
            add log p(y | c) / (1 − p(y | c)) instead. That is a heuristic: it treats a likelihood as a probability of
            the cell, and works because it has the right sign and grows with the evidence. The sum over all maps is
            exact here, for one beam; on a plane it is not affordable, and the model of <SectionLink to="model" /> is
            chosen by hand to have its shape.
          </p>
          <p>
            The <b>likelihood field</b> on the stage replaces the ray by the distance from the end point to the nearest
            occupied cell: a table look-up, smooth where the beam model jumps. It ignores that a wall hides what is
            behind it.
          </p>
        </>
      }
    >
      <p>
        A particle’s weight is p(z | x, m): <b>forwards</b>, from a map and a pose to the reading. The <b>beam model</b>{" "}
        has four parts: the range to the mapped surface, with noise; shorter ranges, from people and things that are not
        in the map; beams without a return; and random readings. Drag each by its handle. The second chart is the{" "}
        <b>inverse</b> model: given one reading, which cells are occupied? Drag z.
      </p>
    </Section>
  );
}
