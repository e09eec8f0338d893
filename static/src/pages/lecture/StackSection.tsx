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
      sources={[
        ["slam-toolbox", ""],
        ["amcl", ""],
        ["nav2-costmap", ""],
      ]}
      after={
        <p>
          Each part trusts the one before. A map with double walls gives poor weights; a wrong pose puts the obstacle
          layer’s marks beside the walls of the static layer, and doors close; a table in the saved map is driven around
          for ever. When a robot does not find its way, look at the picture in this order.
        </p>
      }
    >
      <p>
        The parts together, as in a robot with <b>SLAM Toolbox</b> and <b>Nav2</b>: one drive makes the map, it is
        saved, and does not change any more; on another day a particle filter finds the robot on it; costs, a path, and
        the drive follow. Drag the goal on the stage, press a part to begin with it, or play all of it.
      </p>
    </Section>
  );
}
