import { LaterFigure, Section, type SectionHead, SectionLink } from "../Section";

export function SensorModelsSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<LaterFigure id="sensor-models" />}
      sources={[["probabilistic-robotics", "tables 6.1 and 6.3, sections 9.3 and 9.4"], "amcl"]}
      after={
        <>
          <p>
            Why can’t we get the inverse model from p(z | m) alone? It is a distribution over <b>readings</b>, for one
            whole map. A cell needs a distribution over its two <b>states</b>: Bayes’ rule also takes a prior, and sums
            over all maps that agree with the reading.
          </p>
          <p>
            Some texts add ln p(z | m<sub>i</sub>) / (1 − p(z | m<sub>i</sub>)), as the dashed curve does. Bayes’ rule
            gives ln p(z | m<sub>i</sub>) / p(z | ¬m<sub>i</sub>): how likely the reading is with the cell occupied,
            over how likely with it free. For a yes-or-no sensor with equal error rates both are the same; otherwise the
            heuristic works because its sign is right and the clamp limits its size. The sum over all maps, exact here
            for one beam, is too costly on a plane: the model of <SectionLink to="model" /> is chosen by hand to have
            its shape. Section 9.4 of the book keeps the forward model and searches for the most probable map, without
            independent cells.
          </p>
          <p>
            The <b>likelihood field</b> on the stage replaces the ray by the distance from the end point to the nearest
            occupied cell: a table look-up, and smooth. It ignores that a wall hides what is behind it.
          </p>
        </>
      }
    >
      <p>
        A particle’s weight is p(z | x, m): <b>forwards</b>, from a map and a pose to the reading. The <b>beam model</b>{" "}
        has four parts: the range to the mapped surface, with noise; shorter ranges, from people and things that are not
        in the map; beams without a return; and random readings. The second chart is the <b>inverse</b> model: given one
        reading, which cells are occupied?
      </p>
    </Section>
  );
}
