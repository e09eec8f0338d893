import { Prediction } from "../../../lessons/common/Prediction";
import { LaterFigure, OnStage, Section, type SectionHead } from "../Section";

export function KidnappingSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <OnStage scene="kidnapping" label="A robot that is carried away, and the particles that look for it">
          <LaterFigure id="kidnapping" />
        </OnStage>
      }
      predict={
        <Prediction
          text="The robot was carried away four scans ago. After how many more scans is most of the belief within half a metre of it?"
          axis={{ low: 0, high: 60, unit: "scans" }}
          step={1}
          reveal={async () => (await import("../../../lessons/localization/foundAgain")).foundAgain()}
        />
      }
      sources={[["probabilistic-robotics", "table 8.3"], "amcl"]}
      after={
        <>
          <p>
            Each average follows the mean weight of a scan’s particles at its own rate. The share of random particles is
            max(0, 1 − fast average / slow average). The fast rate has to be much larger: with equal rates no particle
            is ever added.
          </p>
          <p>
            In AMCL both rates are 0 by default, so it does not recover; its documentation suggests 0.001 and 0.1. A
            blocked sensor also gives poor weights: too strong a reaction scatters particles that were right.
          </p>
        </>
      }
    >
      <p>
        Once the particles have converged, resampling draws only from poses that are there: a robot carried away without
        being told stays lost (the <b>kidnapped robot problem</b>). <b>Augmented MCL</b> compares a fast average of the
        weights with a slow one; where the scans fit worse than before, it replaces a share of the particles by random
        poses. <span class="no-print">Press “Drive on”, and kidnap the robot again.</span>
      </p>
    </Section>
  );
}
