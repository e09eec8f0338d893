import { LaterFigure } from "./LaterFigure";
import { OnStage } from "./OnStage";
import { Section, type SectionHead } from "./Section";

export function StackSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <OnStage scene="stack" label="SLAM, the saved map, localization and navigation in one picture">
          <LaterFigure id="stack" />
        </OnStage>
      }
      sources={["slam-toolbox", "amcl", "nav2-costmap"]}
      after={
        <p>
          Each part relies on the one before. A map with double walls gives poor weights; a wrong pose puts the obstacle
          layer’s marks beside the walls and closes doors; a path avoids a table in the saved map for good. When a robot
          does not find its way, check the parts in this order.
        </p>
      }
    >
      <p>
        All parts together, as on a robot with <b>SLAM Toolbox</b> and <b>Nav2</b>: one drive makes the map, which is
        saved; on another day a particle filter finds the robot in it; then come the costs, a path and the drive. Drag
        the goal, or play all of it.
      </p>
    </Section>
  );
}
