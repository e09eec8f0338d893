import { Table91 } from "../../lessons/table91/Table91";
import { OnStage } from "./OnStage";
import { Section, type SectionHead } from "./Section";
import { SectionLink } from "./SectionLink";

export function TableSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <OnStage scene="table" label="Table 9.1, line by line, and the grid that it updates">
          <Table91 />
        </OnStage>
      }
      sources={[["probabilistic-robotics", "tables 9.1 and 9.2"]]}
      after={
        <p>
          The inverse sensor model here is table 9.2: it looks for the beam that is nearest in bearing to the cell, and
          then compares the cell’s distance with that one reading. A loop over all cells for each scan is slow: most
          cells lie outside the field. Programs loop over the beams and the cells along each, as in the next section;{" "}
          <SectionLink to="counting" /> shows where that makes a difference.
        </p>
      }
    >
      <p>
        <cite>Probabilistic Robotics</cite> prints the algorithm as a loop over <em>all</em> cells. Only the cells in
        the <b class="noun-beam">perceptual field</b> of the scan are changed. These are the cells about which this scan
        says something: in the sensor’s field of view, and not behind what it measured. All others keep their value.
      </p>
    </Section>
  );
}
