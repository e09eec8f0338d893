import { LaterFigure, OnStage, Section, type SectionHead } from "../Section";

export function LayersSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <OnStage scene="layers" label="The layers of a costmap">
          <LaterFigure id="layers" />
        </OnStage>
      }
      sources={["nav2-costmap"]}
      after={
        <p>
          The <b>obstacle layer</b> marks where the beams of the current scan end, and clears what they pass. It cannot
          clear a wall of the static layer, whose cost is greater. The <b>dynamic layer</b> removes what has not been
          seen for some time, in Nav2 the spatio-temporal voxel layer.
        </p>
      }
    >
      <p>
        A map says what is occupied; a planner needs the <b>cost</b> of driving through each cell. In Nav2’s costmap 0
        is free, 254 is lethal, 253 is a collision at any heading, 255 is unknown. It is made of <b>layers</b>, the
        saved map first, and the greatest cost counts.{" "}
        <span class="no-print">Drag the crate into view, switch layers off, and read the costs with the cross.</span>
      </p>
    </Section>
  );
}
