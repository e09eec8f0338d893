import { LaterFigure } from "./LaterFigure";
import { OnStage } from "./OnStage";
import { Section, type SectionHead } from "./Section";
import { SectionLink } from "./SectionLink";
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
      sources={[["nav2-costmap", ""]]}
      after={
        <p>
          This is why a costmap has layers: what stands, what is seen now, and what was seen a short time ago have to be
          kept apart. The lifetime is a choice between two errors. Short: a person who stands still is forgotten while
          still there, unless seen again. Long: the robot drives around what is gone. The dotted line is the path of a
          robot that knows.
        </p>
      }
    >
      <p>
        The table of <SectionLink to="forgetting" /> was taken away, and the path still goes around it. Beams alone
        clear an obstacle, and the robot that plans around it does not look there. Where is the table remembered? In the{" "}
        <b>saved map</b> it stays for ever. In the <b>obstacle layer</b> it stays until a beam passes: drag the robot
        towards it. With a <b>lifetime</b> it is forgotten by the clock.
      </p>
    </Section>
  );
}
