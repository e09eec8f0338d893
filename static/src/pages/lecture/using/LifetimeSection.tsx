import { LaterFigure, OnStage, Section, type SectionHead, SectionLink } from "../Section";

export function LifetimeSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <OnStage scene="lifetime" label="A path round a table that is gone">
          <LaterFigure id="lifetime" />
        </OnStage>
      }
      sources={["nav2-costmap"]}
      after={
        <p>
          The lifetime is a choice between two errors. Too short: a person out of view for a moment is removed although
          still there. Too long: the robot drives around something that is gone.
        </p>
      }
    >
      <p>
        As in <SectionLink to="forgetting" />, a table has been removed, and the path still goes around it: only a beam
        clears an obstacle, and a robot that plans around it may never look there. In the <b>saved map</b> the table
        stays for good. In the <b>obstacle layer</b> it stays until a beam passes
        <span class="no-print"> (drag the robot towards it)</span>. With a <b>lifetime</b> it is removed after a set
        time.
      </p>
    </Section>
  );
}
