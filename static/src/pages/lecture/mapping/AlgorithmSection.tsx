import { Pipeline } from "../../../lessons/pipeline/Pipeline";
import { Program } from "../../../lessons/program/Program";
import { algorithmView } from "../../../lessons/stage/controls";
import { Table91 } from "../../../lessons/table91/Table91";
import { Choice } from "../../../ui/Choice";
import { OnStage, Section, type SectionHead, SectionLink } from "../Section";

const VIEWS = [
  { value: "table", label: "table 9.1" },
  { value: "program", label: "beam by beam" },
  { value: "reading", label: "one reading" },
];

export function AlgorithmSection(head: SectionHead) {
  const view = algorithmView.value;
  return (
    <Section
      {...head}
      figure={
        <>
          <Choice
            label="The algorithm as"
            options={VIEWS}
            value={view}
            onChange={(value) => {
              algorithmView.value = value === "program" || value === "reading" ? value : "table";
            }}
          />
          {view === "program" ? (
            <Program />
          ) : (
            <OnStage scene="algorithm" label="The algorithm, step by step, and the grid that it updates">
              {view === "table" ? <Table91 /> : <Pipeline />}
            </OnStage>
          )}
        </>
      }
      sources={[["probabilistic-robotics", "tables 9.1 and 9.2"], "bresenham"]}
      after={
        <>
          <p>
            The inverse sensor model of this loop is <b>table 9.2</b>: it takes the beam whose direction is nearest to
            the cell’s and compares the cell’s distance with that reading. Looping over all cells is slow, since most
            lie outside the field. Programs swap the loops: over the <b class="noun-beam">beams</b> of a scan, then over
            the cells of each beam. <SectionLink to="counting" capital /> shows where the result differs.
          </p>
          <p>
            <b>Beam by beam</b> is that program in Python.
          </p>
        </>
      }
    >
      <p>
        <cite>Probabilistic Robotics</cite> prints the algorithm as a loop over <em>all</em> cells. A scan changes only
        the cells in its <b class="noun-beam">perceptual field</b>: in the sensor’s field of view, and not behind what
        it measured.
      </p>
    </Section>
  );
}
