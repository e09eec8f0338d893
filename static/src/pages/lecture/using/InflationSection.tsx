import { LaterFigure, OnStage, Section, type SectionHead } from "../Section";

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
      sources={["nav2-inflation"]}
      after={
        <p>
          A <b>larger</b> cost_scaling_factor makes the cost fall <b>faster</b>, so paths come closer to walls. A door
          narrower than twice the inscribed radius is closed in any case. With a small inflation radius paths cut
          corners.
        </p>
      }
    >
      <p>
        A planner on a grid treats the robot as a point. <b>Inflation</b> makes up for that: around each lethal cell the
        cost is 253 up to the <b>inscribed radius</b>, where the robot collides at any heading; beyond it the cost falls
        exponentially and ends at the <b>inflation radius</b>.{" "}
        <span class="no-print">
          Drag the curve by its point for cost_scaling_factor, by its foot for inflation_radius.
        </span>
      </p>
    </Section>
  );
}
