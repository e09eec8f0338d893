import { LaterFigure } from "./LaterFigure";
import { OnStage } from "./OnStage";
import { Section, type SectionHead } from "./Section";

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
      sources={[["nav2-costmap", ""]]}
      after={
        <p>
          The <b>obstacle layer</b> marks where the beams of the current scan end, and clears what they pass. By
          default, Nav2 marks up to 2.5 m and clears up to 3 m: a crate farther away is not marked. It cannot clear a
          wall of the static layer, because the greater cost counts. The <b>dynamic layer</b> removes an obstacle that
          has not been seen again for some time; Nav2’s own layers do not, and its documentation refers to the
          spatio-temporal voxel layer for this. A painted zone lies below the inflation here; in Nav2’s list of filters
          a keepout filter comes after all layers, and is not inflated.
        </p>
      }
    >
      <p>
        A map states what is occupied; a planner needs the <b>cost</b> of driving through each cell. Nav2’s costmap has
        one number for each cell: 0 is free, 254 is lethal, 253 means a collision at any heading, 255 is unknown. It is
        made of <b>layers</b>, applied one after the other: each combines its costs with those below, and the greater
        cost counts. The saved map is only the first. Drag the crate into the robot’s view, switch layers off, and read
        with the cross what each says.
      </p>
    </Section>
  );
}
