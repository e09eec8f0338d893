import { LaterFigure } from "./LaterFigure";
import { OnStage } from "./OnStage";
import { Section, type SectionHead } from "./Section";

export function InflationSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <OnStage scene="inflation" label="The inflation of a costmap">
          <LaterFigure id="inflation" />
        </OnStage>
      }
      sources={[["nav2-inflation", ""]]}
      after={
        <p>
          A <b>larger</b> cost_scaling_factor makes the cost fall <b>faster</b>, so paths come closer to walls. A door
          narrower than twice the inscribed radius is closed, whatever the factor. With a small inflation radius the
          middle of a room costs as little as the space near its walls, and paths cut corners; a wide, gentle curve
          keeps them in the middle.
        </p>
      }
    >
      <p>
        A planner that searches a grid treats the robot as a point. <b>Inflation</b> compensates for that: around each
        lethal cell the cost is 253 up to the <b>inscribed radius</b> of the robot’s footprint, where the robot collides
        at any heading; beyond it the cost falls exponentially and ends at the <b>inflation radius</b>. Drag the curve
        by its point for cost_scaling_factor, and by its foot for inflation_radius. The costs on the stage are computed
        again.
      </p>
    </Section>
  );
}
