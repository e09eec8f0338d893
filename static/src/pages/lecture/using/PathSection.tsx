import { LaterFigure, OnStage, Section, type SectionHead } from "../Section";

export function PathSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <OnStage scene="path" label="The search for a path">
          <LaterFigure id="path" />
        </OnStage>
      }
      sources={["dijkstra-1959", "hart", "nav2-navfn"]}
      after={
        <p>
          <b>Dijkstra’s algorithm</b> expands the cell with the least cost so far. <b>A*</b> adds an estimate of the
          cost to go that is never too high, here the distance times the cost of a free cell, and expands fewer cells
          for a path of equal cost.
        </p>
      }
    >
      <p>
        A path is found by a <b>wavefront</b>: from the robot’s cell outwards, each cell gets the least cost of reaching
        it, its <b>potential</b>. A step costs 50 + 0.8 · cost of the cell, as in Nav2’s NavFn. A diagonal step costs √2
        times that here; NavFn has no diagonal steps, and interpolates between two neighbours. Lethal and inscribed
        cells are blocked. The path is traced back from the goal.{" "}
        <span class="no-print">
          Drag the <b>goal</b>.
        </span>
      </p>
    </Section>
  );
}
