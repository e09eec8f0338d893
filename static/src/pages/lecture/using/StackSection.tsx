import { LaterFigure, OnStage, Section, type SectionHead } from "../Section";

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
          Each part relies on the one before: double walls give poor weights, a wrong pose closes doors, a table in the
          saved map is avoided for good. When a robot does not find its way, check them in this order.
        </p>
      }
    >
      <p>
        All parts together, as on a robot with <b>SLAM Toolbox</b> and <b>Nav2</b>: one drive makes the map, the robot
        works with it on another day. <span class="no-print">Drag the goal, or play all of it.</span>
      </p>
    </Section>
  );
}
