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
          A <b>larger</b> cost_scaling_factor makes the cost fall <b>faster</b>: paths come nearer to walls. Where two
          walls are closer than twice the inscribed radius, the door is shut, whatever the factor. Where the radius of
          inflation is small, the middle of a room is as good as its edge, and paths cut corners; a curve that is wide
          and gentle leads them along the middle.
        </p>
      }
    >
      <p>
        A planner that searches for cells takes the robot for a point. <b>Inflation</b> makes up for it: around each
        lethal cell the cost is 253 up to the <b>inscribed radius</b> of the robot’s footprint, where any heading
        collides; then it falls exponentially, and it ends at the <b>inflation radius</b>. Drag the curve by its point
        for cost_scaling_factor, and by its foot for inflation_radius. The stage is inflated anew.
      </p>
    </Section>
  );
}
