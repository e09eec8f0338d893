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
      sources={[
        ["probabilistic-robotics", "tables 6.1 and 6.3 for the models, chapter 9 for inverse models from forward ones"],
        ["amcl", "for the names of the parameters"],
      ]}
      after={
        <>
          <p>
            Why does p(z | m) alone not give the inverse model? The forward model is a distribution over <b>readings</b>
            : it sums to one over z, for one whole map. A cell needs a distribution over its two <b>states</b>, and a
            reading alone does not give it: Bayes’ rule also takes a prior, and sums over all maps that agree with the
            reading. Cells before z are free <i>because</i> the beam passed them; cells behind z keep their prior{" "}
            <i>because</i> nothing was measured there. The dashed curve is low in both places and cannot tell them
            apart. Drag the prior: the inverse changes, the forward model does not.
          </p>
          <p>
            The sum over all maps is exact here, for one beam: the reading depends on the first occupied cell only. On a
            plane with many beams it is not affordable; the inverse model of <SectionLink to="model" /> is chosen by
            hand to have its shape.
          </p>
          <p>
            The <b>likelihood field</b> on the stage is the other forward model: it replaces the ray by the distance
            from the end point to the nearest occupied cell. That is a table look-up, and smooth where the beam model is
            discontinuous. Its disadvantage: it ignores that a wall hides what is behind it.
          </p>
        </>
      }
    >
      <p>
        A particle’s weight is p(z | x, m): <b>forwards</b>, from a map and a pose to the reading. The <b>beam model</b>{" "}
        has four parts: the range to the surface in the map, with noise; shorter ranges, from people and things that are
        not in the map; beams without a return; and random readings. Drag each part by its handle. The second chart
        shows the <b>inverse</b> model, as in the first half of this lecture: given one reading, which cells are
        occupied? Drag z along the beam.
      </p>
    </Section>
  );
}
